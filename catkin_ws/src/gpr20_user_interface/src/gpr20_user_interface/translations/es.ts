<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE TS>
<TS version="2.1" language="es" sourcelanguage="en">
<context>
  <name>ControlView</name>
  <message>
    <source>Arrows change by</source>
    <translation>Las flechas cambian</translation>
  </message>
  <message>
    <source>PAUSE</source>
    <translation>PAUSA</translation>
  </message>
  <message>
    <source>PROFILES</source>
    <translation>PERFILES</translation>
  </message>
  <message>
    <source>RESUME</source>
    <translation>SEGUIR</translation>
  </message>
  <message>
    <source>START</source>
    <translation>INICIAR</translation>
  </message>
</context>
<context>
  <name>Fields</name>
  <message>
    <source>fewer, a survey has at most {most} traces</source>
    <translation>menos, una campaña tiene como máximo {most} trazas</translation>
  </message>
  <message>
    <source>Antenna rotations (°)</source>
    <translation>Giros de las antenas (°)</translation>
  </message>
  <message>
    <source>Frequency points</source>
    <translation>Puntos de frecuencia</translation>
  </message>
  <message>
    <source>Start frequency (MHz)</source>
    <translation>Frecuencia inicial (MHz)</translation>
  </message>
  <message>
    <source>Stop frequency (MHz)</source>
    <translation>Frecuencia final (MHz)</translation>
  </message>
  <message>
    <source>VNA address</source>
    <translation>Dirección del VNA</translation>
  </message>
  <message>
    <source>X points</source>
    <translation>Puntos en X</translation>
  </message>
  <message>
    <source>X start (mm)</source>
    <translation>Inicio de X (mm)</translation>
  </message>
  <message>
    <source>X stop (mm)</source>
    <translation>Fin de X (mm)</translation>
  </message>
  <message>
    <source>Y points</source>
    <translation>Puntos en Y</translation>
  </message>
  <message>
    <source>Y start (mm)</source>
    <translation>Inicio de Y (mm)</translation>
  </message>
  <message>
    <source>Y stop (mm)</source>
    <translation>Fin de Y (mm)</translation>
  </message>
  <message>
    <source>a whole number from {lower} to {upper}</source>
    <translation>un número entero de {lower} a {upper}</translation>
  </message>
  <message>
    <source>a whole number, {lower} or more</source>
    <translation>un número entero, {lower} o más</translation>
  </message>
  <message>
    <source>different rotations from {lower} to {upper}, each a multiple of {step}, with commas</source>
    <translation>giros distintos de {lower} a {upper}, cada uno múltiplo de {step}, separados por comas</translation>
  </message>
  <message>
    <source>four whole numbers from 0 to 255</source>
    <translation>cuatro números enteros de 0 a 255</translation>
  </message>
  <message>
    <source>a number such as 12.5, {allowed}</source>
    <translation>un número como 12.5, {allowed}</translation>
  </message>
  <message>
    <source>from {lower} to {upper}</source>
    <translation>de {lower} a {upper}</translation>
  </message>
  <message>
    <source>from {lower} to {upper}, below the stop frequency</source>
    <translation>de {lower} a {upper}, menor que la frecuencia final</translation>
  </message>
  <message>
    <source>the points between start and stop must be at least {step} mm apart</source>
    <translation>los puntos entre inicio y fin deben distar al menos {step} mm</translation>
  </message>
  <message>
    <source>{field}: {allowed}</source>
    <translation>{field}: {allowed}</translation>
  </message>
</context>
<context>
  <name>HealthPanel</name>
  <message>
    <source>Calibration</source>
    <translation>Calibración</translation>
  </message>
  <message>
    <source>FAULT</source>
    <translation>FALLO</translation>
  </message>
  <message>
    <source>Free disk</source>
    <translation>Disco libre</translation>
  </message>
  <message>
    <source>GONE</source>
    <translation>AUSENTE</translation>
  </message>
  <message>
    <source>LOOK</source>
    <translation>AVISO</translation>
  </message>
  <message>
    <source>OK</source>
    <translation>BIEN</translation>
  </message>
  <message>
    <source>high accuracy</source>
    <translation>precisión alta</translation>
  </message>
  <message>
    <source>low: temperature</source>
    <translation>baja: temperatura</translation>
  </message>
  <message>
    <source>moderate: other power level</source>
    <translation>media: otra potencia</translation>
  </message>
  <message>
    <source>moderate: temperature</source>
    <translation>media: temperatura</translation>
  </message>
  <message>
    <source>none</source>
    <translation>ninguna</translation>
  </message>
  <message>
    <source>not heard</source>
    <translation>no se oye</translation>
  </message>
</context>
<context>
  <name>KeyPad</name>
  <message>
    <source>Cancel</source>
    <translation>Cancelar</translation>
  </message>
  <message>
    <source>Clear</source>
    <translation>Borrar</translation>
  </message>
  <message>
    <source>OK</source>
    <translation>Aceptar</translation>
  </message>
</context>
<context>
  <name>MainWindow</name>
  <message>
    <source>CONTROL</source>
    <translation>CONTROL</translation>
  </message>
  <message>
    <source>GPR-20</source>
    <translation>GPR-20</translation>
  </message>
  <message>
    <source>MAP</source>
    <translation>MAPA</translation>
  </message>
  <message>
    <source>RADAR</source>
    <translation>RADAR</translation>
  </message>
  <message>
    <source>STATUS</source>
    <translation>ESTADO</translation>
  </message>
  <message>
    <source>SURVEYS</source>
    <translation>CAMPAÑAS</translation>
  </message>
</context>
<context>
  <name>MapCanvas</name>
  <message>
    <source>No survey yet: the map appears when one starts.</source>
    <translation>Todavía no hay campaña: el mapa aparece cuando empieza una.</translation>
  </message>
  <message>
    <source>X mm</source>
    <translation>X mm</translation>
  </message>
  <message>
    <source>Y mm</source>
    <translation>Y mm</translation>
  </message>
</context>
<context>
  <name>MapView</name>
  <message>
    <source>Antenna</source>
    <translation>Antena</translation>
  </message>
  <message>
    <source>Antenna {rotation:g}°</source>
    <translation>Antena {rotation:g}°</translation>
  </message>
  <message>
    <source>Delay ns</source>
    <translation>Retardo ns</translation>
  </message>
  <message>
    <source>Depth mm</source>
    <translation>Profundidad mm</translation>
  </message>
  <message>
    <source>Done</source>
    <translation>Hecho</translation>
  </message>
  <message>
    <source>Failed</source>
    <translation>Fallido</translation>
  </message>
  <message>
    <source>Level dB</source>
    <translation>Nivel dB</translation>
  </message>
  <message>
    <source>Missing</source>
    <translation>Falta</translation>
  </message>
  <message>
    <source>Next not done</source>
    <translation>Siguiente sin hacer</translation>
  </message>
  <message>
    <source>Partly</source>
    <translation>En parte</translation>
  </message>
  <message>
    <source>Touch a stop to see its trace.</source>
    <translation>Toque un punto para ver su traza.</translation>
  </message>
  <message>
    <source>X {x:g} mm, Y {y:g} mm: {state}</source>
    <translation>X {x:g} mm, Y {y:g} mm: {state}</translation>
  </message>
  <message>
    <source>no trace to show</source>
    <translation>no hay traza que mostrar</translation>
  </message>
</context>
<context>
  <name>Notice</name>
  <message>
    <source>CLOSE</source>
    <translation>CERRAR</translation>
  </message>
  <message>
    <source>Next: look at STATUS. If the robot moves, press STOP again or switch its power off.</source>
    <translation>Siguiente paso: mire ESTADO. Si el robot se mueve, pulse PARAR otra vez o corte su corriente.</translation>
  </message>
  <message>
    <source>Next: look at STATUS. STOP ends the survey at once, and it can be resumed.</source>
    <translation>Siguiente paso: mire ESTADO. PARAR termina la campaña enseguida, y se puede seguir después.</translation>
  </message>
  <message>
    <source>Next: remove the cause named above, look at STATUS, then RESUME again.</source>
    <translation>Siguiente paso: elimine la causa indicada, mire ESTADO y pulse SEGUIR otra vez.</translation>
  </message>
  <message>
    <source>Next: remove the cause named above, look at STATUS, then START again.</source>
    <translation>Siguiente paso: elimine la causa indicada, mire ESTADO y pulse INICIAR otra vez.</translation>
  </message>
  <message>
    <source>Next: remove the cause named above, or use another profile.</source>
    <translation>Siguiente paso: elimine la causa indicada o use otro perfil.</translation>
  </message>
  <message>
    <source>STOP was not accepted.</source>
    <translation>No se aceptó PARAR.</translation>
  </message>
  <message>
    <source>The profile cannot be used.</source>
    <translation>El perfil no se puede usar.</translation>
  </message>
  <message>
    <source>The survey was not paused.</source>
    <translation>La campaña no se puso en pausa.</translation>
  </message>
  <message>
    <source>The survey was not resumed.</source>
    <translation>La campaña no siguió.</translation>
  </message>
  <message>
    <source>The survey was not started.</source>
    <translation>La campaña no se inició.</translation>
  </message>
</context>
<context>
  <name>ParameterFormView</name>
  <message>
    <source>Antennas °</source>
    <translation>Antenas °</translation>
  </message>
  <message>
    <source>MHz</source>
    <translation>MHz</translation>
  </message>
  <message>
    <source>Points</source>
    <translation>Puntos</translation>
  </message>
  <message>
    <source>Start</source>
    <translation>Inicio</translation>
  </message>
  <message>
    <source>Stop</source>
    <translation>Fin</translation>
  </message>
  <message>
    <source>VNA</source>
    <translation>VNA</translation>
  </message>
  <message>
    <source>X mm</source>
    <translation>X mm</translation>
  </message>
  <message>
    <source>Y mm</source>
    <translation>Y mm</translation>
  </message>
</context>
<context>
  <name>PastSurveysView</name>
  <message>
    <source>CANNOT BE READ</source>
    <translation>ILEGIBLE</translation>
  </message>
  <message>
    <source>Coverage</source>
    <translation>Cobertura</translation>
  </message>
  <message>
    <source>INCOMPLETE</source>
    <translation>INCOMPLETA</translation>
  </message>
  <message>
    <source>It is on its way.</source>
    <translation>Está en curso.</translation>
  </message>
  <message>
    <source>It has not ended properly.</source>
    <translation>No terminó correctamente.</translation>
  </message>
  <message>
    <source>Older</source>
    <translation>Anteriores</translation>
  </message>
  <message>
    <source>Refresh</source>
    <translation>Actualizar</translation>
  </message>
  <message>
    <source>Resume</source>
    <translation>Reanudar</translation>
  </message>
  <message>
    <source>Show in RADAR</source>
    <translation>Ver en RADAR</translation>
  </message>
  <message>
    <source>Started (UTC)</source>
    <translation>Inicio (UTC)</translation>
  </message>
  <message>
    <source>Touch a survey.</source>
    <translation>Toque una campaña.</translation>
  </message>
  <message>
    <source>Traces</source>
    <translation>Trazas</translation>
  </message>
  <message>
    <source>complete</source>
    <translation>completa</translation>
  </message>
  <message>
    <source>running</source>
    <translation>en curso</translation>
  </message>
  <message>
    <source>simulated</source>
    <translation>simulada</translation>
  </message>
</context>
<context>
  <name>PositionPanel</name>
  <message>
    <source>Height m</source>
    <translation>Altura m</translation>
  </message>
  <message>
    <source>Now</source>
    <translation>Ahora</translation>
  </message>
  <message>
    <source>Target</source>
    <translation>Destino</translation>
  </message>
  <message>
    <source>X mm</source>
    <translation>X mm</translation>
  </message>
  <message>
    <source>Y mm</source>
    <translation>Y mm</translation>
  </message>
  <message>
    <source>Z °</source>
    <translation>Z °</translation>
  </message>
</context>
<context>
  <name>PreviewPanel</name>
  <message>
    <source>Disk space</source>
    <translation>Espacio en disco</translation>
  </message>
  <message>
    <source>Estimated time</source>
    <translation>Tiempo estimado</translation>
  </message>
  <message>
    <source>Frequency step</source>
    <translation>Paso de frecuencia</translation>
  </message>
  <message>
    <source>Range in air</source>
    <translation>Alcance en aire</translation>
  </message>
  <message>
    <source>Resolution in air</source>
    <translation>Resolución en aire</translation>
  </message>
  <message>
    <source>Spacing X, Y</source>
    <translation>Separación X, Y</translation>
  </message>
  <message>
    <source>Stops</source>
    <translation>Paradas</translation>
  </message>
  <message>
    <source>Traces</source>
    <translation>Trazas</translation>
  </message>
</context>
<context>
  <name>ProfilesView</name>
  <message>
    <source>CLOSE</source>
    <translation>CERRAR</translation>
  </message>
  <message>
    <source>DELETE</source>
    <translation>ELIMINAR</translation>
  </message>
  <message>
    <source>LOAD</source>
    <translation>CARGAR</translation>
  </message>
  <message>
    <source>Profiles of parameters</source>
    <translation>Perfiles de parámetros</translation>
  </message>
  <message>
    <source>SAVE AS</source>
    <translation>GUARDAR</translation>
  </message>
  <message>
    <source>SURE?</source>
    <translation>¿SEGURO?</translation>
  </message>
  <message>
    <source>Save profile as</source>
    <translation>Guardar el perfil como</translation>
  </message>
  <message>
    <source>a new name of at most {most} letters a to z, digits, blanks, - and _; first a letter or digit, no blank last</source>
    <translation>un nombre nuevo de {most} letras de la a a la z, cifras, espacios, - y _ como máximo; primero una letra o cifra, sin espacio al final</translation>
  </message>
</context>
<context>
  <name>ProgressPanel</name>
  <message>
    <source>no survey</source>
    <translation>sin campaña</translation>
  </message>
  <message>
    <source>{d}d:{h}h:{m}m:{s}s remaining (by the plan)</source>
    <translation>quedan {d}d:{h}h:{m}m:{s}s (según el plan)</translation>
  </message>
  <message>
    <source>{d}d:{h}h:{m}m:{s}s remaining (measured)</source>
    <translation>quedan {d}d:{h}h:{m}m:{s}s (según lo medido)</translation>
  </message>
  <message>
    <source>{percent} %</source>
    <translation>{percent} %</translation>
  </message>
  <message>
    <source>{visited} of {total} traces, {remaining} to go</source>
    <translation>{visited} de {total} trazas, faltan {remaining}</translation>
  </message>
</context>
<context>
  <name>RadarControls</name>
  <message>
    <source>Antenna
{rotation:g}°</source>
    <translation>Antena
{rotation:g}°</translation>
  </message>
  <message>
    <source>Axis
depth</source>
    <translation>Eje
profund.</translation>
  </message>
  <message>
    <source>Axis
time</source>
    <translation>Eje
tiempo</translation>
  </message>
  <message>
    <source>Background
kept</source>
    <translation>Fondo
incluido</translation>
  </message>
  <message>
    <source>Background
removed</source>
    <translation>Fondo
quitado</translation>
  </message>
  <message>
    <source>Gain</source>
    <translation>Ganancia</translation>
  </message>
  <message>
    <source>Permittivity</source>
    <translation>Permitividad</translation>
  </message>
  <message>
    <source>Scale
dB</source>
    <translation>Escala
dB</translation>
  </message>
  <message>
    <source>Scale
linear</source>
    <translation>Escala
lineal</translation>
  </message>
  <message>
    <source>{value:g} dB/ns</source>
    <translation>{value:g} dB/ns</translation>
  </message>
</context>
<context>
  <name>RadarView</name>
  <message>
    <source>Back to the running survey</source>
    <translation>Volver a la campaña en curso</translation>
  </message>
  <message>
    <source>Delay ns</source>
    <translation>Retardo ns</translation>
  </message>
  <message>
    <source>Depth mm</source>
    <translation>Profundidad mm</translation>
  </message>
  <message>
    <source>Grey was not measured. No echo does not mean no mine.</source>
    <translation>Gris: no medido. Sin eco no significa sin mina.</translation>
  </message>
  <message>
    <source>Last trace</source>
    <translation>Última traza</translation>
  </message>
  <message>
    <source>Level</source>
    <translation>Nivel</translation>
  </message>
  <message>
    <source>Level dB</source>
    <translation>Nivel dB</translation>
  </message>
  <message>
    <source>Line</source>
    <translation>Línea</translation>
  </message>
  <message>
    <source>Line at Y {y:g} mm</source>
    <translation>Línea en Y {y:g} mm</translation>
  </message>
  <message>
    <source>PAST SURVEY {name}</source>
    <translation>CAMPAÑA PASADA {name}</translation>
  </message>
  <message>
    <source>SIMULATED</source>
    <translation>SIMULADO</translation>
  </message>
  <message>
    <source>Slice at depth {depth:.0f} mm</source>
    <translation>Corte a {depth:.0f} mm de profundidad</translation>
  </message>
  <message>
    <source>X mm</source>
    <translation>X mm</translation>
  </message>
  <message>
    <source>Y mm</source>
    <translation>Y mm</translation>
  </message>
  <message>
    <source>background is kept until there are {count} traces</source>
    <translation>el fondo se incluye hasta que haya {count} trazas</translation>
  </message>
  <message>
    <source>cannot be shown: {count}</source>
    <translation>no se pueden mostrar: {count}</translation>
  </message>
  <message>
    <source>no height was measured: depth is not known</source>
    <translation>no se midió la altura: no se conoce la profundidad</translation>
  </message>
  <message>
    <source>{count} of {planned} traces</source>
    <translation>{count} de {planned} trazas</translation>
  </message>
</context>
<context>
  <name>RobotText</name>
  <message>
    <source>AN AXIS STILL MOVES: switch the motors off</source>
    <translation>UN EJE TODAVÍA SE MUEVE: corte la corriente de los motores</translation>
  </message>
  <message>
    <source>Broken pipe</source>
    <translation>conexión rota</translation>
  </message>
  <message>
    <source>Connection refused</source>
    <translation>conexión rechazada</translation>
  </message>
  <message>
    <source>Connection reset by peer</source>
    <translation>conexión cortada por el otro lado</translation>
  </message>
  <message>
    <source>Connection timed out</source>
    <translation>tiempo de conexión agotado</translation>
  </message>
  <message>
    <source>Disk quota exceeded</source>
    <translation>cuota de disco agotada</translation>
  </message>
  <message>
    <source>File exists</source>
    <translation>el archivo ya existe</translation>
  </message>
  <message>
    <source>INCOMPLETE: {stored} of {planned} planned traces are stored, {failed} failed, {missing} not visited</source>
    <translation>INCOMPLETA: {stored} de {planned} trazas previstas guardadas, {failed} fallidas, {missing} sin visitar</translation>
  </message>
  <message>
    <source>Input/output error</source>
    <translation>error de entrada/salida</translation>
  </message>
  <message>
    <source>Is a directory</source>
    <translation>es una carpeta</translation>
  </message>
  <message>
    <source>Network is unreachable</source>
    <translation>red inalcanzable</translation>
  </message>
  <message>
    <source>No route to host</source>
    <translation>sin ruta hasta el equipo</translation>
  </message>
  <message>
    <source>No space left on device</source>
    <translation>no queda espacio en el disco</translation>
  </message>
  <message>
    <source>No such file or directory</source>
    <translation>no existe el archivo o la carpeta</translation>
  </message>
  <message>
    <source>Not a directory</source>
    <translation>no es una carpeta</translation>
  </message>
  <message>
    <source>Operation not permitted</source>
    <translation>operación no permitida</translation>
  </message>
  <message>
    <source>Permission denied</source>
    <translation>permiso denegado</translation>
  </message>
  <message>
    <source>Read-only file system</source>
    <translation>el sistema de archivos es de solo lectura</translation>
  </message>
  <message>
    <source>S21 is strong: up to {level} dB, expected are {limit} dB at most</source>
    <translation>S21 es fuerte: hasta {level} dB, se esperan {limit} dB como máximo</translation>
  </message>
  <message>
    <source>S21 is weak: {level} dB in the middle, expected are {limit} dB or more</source>
    <translation>S21 es débil: {level} dB en el centro, se esperan {limit} dB o más</translation>
  </message>
  <message>
    <source>SIMULATED VNA was reset and lost its network settings</source>
    <translation>el VNA SIMULADO se reinició y perdió su configuración de red</translation>
  </message>
  <message>
    <source>SIMULATED robot has faults: {faults}</source>
    <translation>el robot SIMULADO tiene fallos: {faults}</translation>
  </message>
  <message>
    <source>SIMULATED robot works</source>
    <translation>el robot SIMULADO funciona</translation>
  </message>
  <message>
    <source>[Errno {number}] {reason}</source>
    <translation>[Errno {number}] {reason}</translation>
  </message>
  <message>
    <source>[Errno {number}] {reason}: '{path}'</source>
    <translation>[Errno {number}] {reason}: '{path}'</translation>
  </message>
  <message>
    <source>[Errno {number}] {reason}: '{path}' -&gt; '{other}'</source>
    <translation>[Errno {number}] {reason}: '{path}' -&gt; '{other}'</translation>
  </message>
  <message>
    <source>a file of this name exists with other content and was left alone</source>
    <translation>ya existe un archivo de este nombre con otro contenido y no se tocó</translation>
  </message>
  <message>
    <source>a pulse was {late} ms late near {coordinate} {unit} at a speed at which the motor can lose steps: the position is not trusted</source>
    <translation>un pulso llegó {late} ms tarde cerca de {coordinate} {unit}, a una velocidad a la que el motor puede perder pasos: la posición no es de fiar</translation>
  </message>
  <message>
    <source>a simulated</source>
    <translation>un robot simulado</translation>
  </message>
  <message>
    <source>a survey is {state}: {reason}</source>
    <translation>una campaña está en {state}: {reason}</translation>
  </message>
  <message>
    <source>allowed are 1 to {most} letters, digits, blanks, - and _, with a letter or digit first and no blank last</source>
    <translation>se permiten de 1 a {most} letras, cifras, espacios, - y _, con una letra o cifra al principio y sin espacio al final</translation>
  </message>
  <message>
    <source>another request is still being carried out after {limit} s (opening a large survey again takes long)</source>
    <translation>otra petición sigue en curso tras {limit} s (reabrir una campaña grande tarda)</translation>
  </message>
  <message>
    <source>another survey cannot be resumed</source>
    <translation>no se puede seguir con otra campaña</translation>
  </message>
  <message>
    <source>another survey cannot start</source>
    <translation>otra campaña no puede empezar</translation>
  </message>
  <message>
    <source>ask again when it has ended</source>
    <translation>pida otra vez cuando haya terminado</translation>
  </message>
  <message>
    <source>at most {limit} m is allowed</source>
    <translation>se permite como máximo {limit} m</translation>
  </message>
  <message>
    <source>calibrate it again</source>
    <translation>calíbrelo otra vez</translation>
  </message>
  <message>
    <source>calibrate it before going on</source>
    <translation>calíbrelo antes de seguir</translation>
  </message>
  <message>
    <source>calibrate it, or change accepted_calibrations (now {accepted})</source>
    <translation>calíbrelo, o cambie accepted_calibrations (ahora {accepted})</translation>
  </message>
  <message>
    <source>calibrated, accuracy high</source>
    <translation>calibrado, precisión alta</translation>
  </message>
  <message>
    <source>call the service connection again</source>
    <translation>llame otra vez al servicio connection</translation>
  </message>
  <message>
    <source>call the service connection first</source>
    <translation>llame antes al servicio connection</translation>
  </message>
  <message>
    <source>call the service freq_sweep_setup first</source>
    <translation>llame antes al servicio freq_sweep_setup</translation>
  </message>
  <message>
    <source>check its motor and its node</source>
    <translation>compruebe su motor y su nodo</translation>
  </message>
  <message>
    <source>check its plug and supply</source>
    <translation>compruebe su enchufe y su alimentación</translation>
  </message>
  <message>
    <source>check that both antennas are connected</source>
    <translation>compruebe que ambas antenas están conectadas</translation>
  </message>
  <message>
    <source>check that it is in VNA mode and not operated by hand</source>
    <translation>compruebe que está en modo VNA y que nadie lo maneja</translation>
  </message>
  <message>
    <source>check that it sees the ground and how high the antennas hang</source>
    <translation>compruebe que ve el suelo y a qué altura cuelgan las antenas</translation>
  </message>
  <message>
    <source>check that its axis_driver node runs</source>
    <translation>compruebe que su nodo axis_driver funciona</translation>
  </message>
  <message>
    <source>check that its node runs</source>
    <translation>compruebe que su nodo funciona</translation>
  </message>
  <message>
    <source>check that its node runs and does not hang</source>
    <translation>compruebe que su nodo funciona y no está colgado</translation>
  </message>
  <message>
    <source>check that nobody changed the VNA's bandwidth, and its network</source>
    <translation>compruebe que nadie cambió el ancho de banda del VNA, y su red</translation>
  </message>
  <message>
    <source>check that nobody operates it by hand</source>
    <translation>compruebe que nadie lo maneja</translation>
  </message>
  <message>
    <source>check that the VNA sweeps and is not in zero span</source>
    <translation>compruebe que el VNA barre y no está en span cero</translation>
  </message>
  <message>
    <source>check that the instrument is in VNA mode and not operated by hand</source>
    <translation>compruebe que el instrumento está en modo VNA y que nadie lo maneja</translation>
  </message>
  <message>
    <source>check the VNA and its network cable</source>
    <translation>compruebe el VNA y su cable de red</translation>
  </message>
  <message>
    <source>check the address, or the parameters maker and model</source>
    <translation>compruebe la dirección, o los parámetros maker y model</translation>
  </message>
  <message>
    <source>check the address, the cable and that it is on</source>
    <translation>compruebe la dirección, el cable y que esté encendido</translation>
  </message>
  <message>
    <source>check the disk</source>
    <translation>compruebe el disco</translation>
  </message>
  <message>
    <source>check the disk and the processing node</source>
    <translation>compruebe el disco y el nodo vna_processing</translation>
  </message>
  <message>
    <source>check the sensor's supply and that the antennas stand still</source>
    <translation>compruebe la alimentación del sensor y que las antenas estén quietas</translation>
  </message>
  <message>
    <source>check the switch and the belt</source>
    <translation>compruebe el interruptor y la correa</translation>
  </message>
  <message>
    <source>check the switch, its cable and the motor</source>
    <translation>compruebe el interruptor, su cable y el motor</translation>
  </message>
  <message>
    <source>check the wiring</source>
    <translation>compruebe el cableado</translation>
  </message>
  <message>
    <source>check wiring and supply</source>
    <translation>compruebe el cableado y la alimentación</translation>
  </message>
  <message>
    <source>checking the robot</source>
    <translation>comprobando el robot</translation>
  </message>
  <message>
    <source>checking the robot before going on</source>
    <translation>comprobando el robot antes de seguir</translation>
  </message>
  <message>
    <source>complete: all {planned} planned traces are stored</source>
    <translation>completa: guardadas las {planned} trazas previstas</translation>
  </message>
  <message>
    <source>connected to {identity}</source>
    <translation>conectado a {identity}</translation>
  </message>
  <message>
    <source>every number of the trace is zero</source>
    <translation>todos los números de la traza son cero</translation>
  </message>
  <message>
    <source>expected is {expected}</source>
    <translation>se espera {expected}</translation>
  </message>
  <message>
    <source>finished, {verdict}</source>
    <translation>terminada, {verdict}</translation>
  </message>
  <message>
    <source>free space on the disk, or let the parameter `profiles` name another folder</source>
    <translation>libere espacio en el disco o indique otra carpeta con el parámetro `profiles`</translation>
  </message>
  <message>
    <source>height {height} m</source>
    <translation>altura {height} m</translation>
  </message>
  <message>
    <source>hold a hand under it: if that ends this, it works, and frozen_readings may be larger, or 0 for no such check</source>
    <translation>ponga una mano debajo: si con eso termina, funciona, y frozen_readings puede ser mayor, o 0 para no comprobarlo</translation>
  </message>
  <message>
    <source>holding: {reason}</source>
    <translation>a la espera: {reason}</translation>
  </message>
  <message>
    <source>home it</source>
    <translation>llévelo a su origen</translation>
  </message>
  <message>
    <source>home it before moving it</source>
    <translation>llévelo a su origen antes de moverlo</translation>
  </message>
  <message>
    <source>home the axis</source>
    <translation>lleve el eje a su origen</translation>
  </message>
  <message>
    <source>home the axis, and lighten the load of this computer</source>
    <translation>lleve el eje a su origen y descargue de trabajo este ordenador</translation>
  </message>
  <message>
    <source>homed</source>
    <translation>con origen</translation>
  </message>
  <message>
    <source>homing the axes</source>
    <translation>llevando los ejes a su origen</translation>
  </message>
  <message>
    <source>homing the {axis} axis failed: {reason}</source>
    <translation>el eje {axis} no llegó a su origen: {reason}</translation>
  </message>
  <message>
    <source>homing was stopped</source>
    <translation>la búsqueda del origen se paró</translation>
  </message>
  <message>
    <source>if not, replace it</source>
    <translation>si no, cámbielo</translation>
  </message>
  <message>
    <source>if the survey's folder was moved or renamed, put it back, then resume the survey</source>
    <translation>si la carpeta de la campaña se movió o cambió de nombre, devuélvala a su sitio y reanude la campaña</translation>
  </message>
  <message>
    <source>it was moved, removed or replaced while it was written</source>
    <translation>se movió, se borró o se sustituyó mientras se escribía</translation>
  </message>
  <message>
    <source>this is no ordinary file</source>
    <translation>esto no es un archivo normal</translation>
  </message>
  <message>
    <source>this is a symbolic link, which is not followed</source>
    <translation>esto es un enlace simbólico, que no se sigue</translation>
  </message>
  <message>
    <source>it cannot go on with {kind} one</source>
    <translation>no puede seguir con {kind}</translation>
  </message>
  <message>
    <source>it ended without a result</source>
    <translation>terminó sin resultado</translation>
  </message>
  <message>
    <source>it failed before with: {reason}</source>
    <translation>falló antes con: {reason}</translation>
  </message>
  <message>
    <source>it is gone</source>
    <translation>ya no está</translation>
  </message>
  <message>
    <source>it is larger than {most} bytes</source>
    <translation>ocupa más de {most} bytes</translation>
  </message>
  <message>
    <source>it is nested more than {most} levels deep</source>
    <translation>tiene más de {most} niveles de anidamiento</translation>
  </message>
  <message>
    <source>it is not YAML: {details}</source>
    <translation>no es YAML: {details}</translation>
  </message>
  <message>
    <source>it may still end, asking again is safe</source>
    <translation>aún puede terminar, se puede pedir otra vez sin riesgo</translation>
  </message>
  <message>
    <source>it measures from {lowest} to {highest} m</source>
    <translation>mide de {lowest} a {highest} m</translation>
  </message>
  <message>
    <source>it must be a list</source>
    <translation>debe ser una lista</translation>
  </message>
  <message>
    <source>it must be a number of type {kind_of}</source>
    <translation>debe ser un número de tipo {kind_of}</translation>
  </message>
  <message>
    <source>it must be more than zero</source>
    <translation>debe ser mayor que cero</translation>
  </message>
  <message>
    <source>it must be of type {kind_of}</source>
    <translation>debe ser de tipo {kind_of}</translation>
  </message>
  <message>
    <source>it must lie between {lowest} and {highest}</source>
    <translation>debe estar entre {lowest} y {highest}</translation>
  </message>
  <message>
    <source>it takes longer than {limit} s in all</source>
    <translation>tarda en total más de {limit} s</translation>
  </message>
  <message>
    <source>it was not begun</source>
    <translation>no se empezó</translation>
  </message>
  <message>
    <source>known are {names}</source>
    <translation>se conocen {names}</translation>
  </message>
  <message>
    <source>launch with the former parameters, or start a new survey</source>
    <translation>arranque con los parámetros de antes, o inicie una campaña nueva</translation>
  </message>
  <message>
    <source>look at the VNA's display, and switch it off and on if this goes on</source>
    <translation>mire la pantalla del VNA, y apáguelo y enciéndalo si esto sigue</translation>
  </message>
  <message>
    <source>look at what else this computer does, and home the axis</source>
    <translation>mire qué más hace este ordenador y lleve el eje a su origen</translation>
  </message>
  <message>
    <source>look for disk errors with dmesg and mount it writable</source>
    <translation>busque errores del disco con dmesg y móntelo con escritura</translation>
  </message>
  <message>
    <source>low, the temperature moved by more than 10 degrees</source>
    <translation>baja, la temperatura cambió más de 10 grados</translation>
  </message>
  <message>
    <source>make space</source>
    <translation>haga sitio</translation>
  </message>
  <message>
    <source>make space and store again</source>
    <translation>haga sitio y guarde otra vez</translation>
  </message>
  <message>
    <source>make the folder and what is in it readable and writable for this user</source>
    <translation>dé a este usuario permiso de lectura y escritura en la carpeta y lo que contiene</translation>
  </message>
  <message>
    <source>measured again as a control, point {index} differs by {difference} dB from the stored trace</source>
    <translation>medido otra vez como control, el punto {index} difiere en {difference} dB de la traza guardada</translation>
  </message>
  <message>
    <source>measured again as a control, point {index} differs by {difference} dB from the stored trace, the height by {height} mm</source>
    <translation>medido otra vez como control, el punto {index} difiere en {difference} dB de la traza guardada, la altura en {height} mm</translation>
  </message>
  <message>
    <source>measuring</source>
    <translation>midiendo</translation>
  </message>
  <message>
    <source>measuring point {index} again as a control</source>
    <translation>midiendo otra vez el punto {index} como control</translation>
  </message>
  <message>
    <source>messages of other topics were dropped</source>
    <translation>se perdieron mensajes de otros temas</translation>
  </message>
  <message>
    <source>moderate, the power level was changed</source>
    <translation>media, se cambió la potencia</translation>
  </message>
  <message>
    <source>moderate, the temperature moved by more than 5 degrees</source>
    <translation>media, la temperatura cambió más de 5 grados</translation>
  </message>
  <message>
    <source>move it away</source>
    <translation>quítelo de ahí</translation>
  </message>
  <message>
    <source>move it out of the survey's folder and store again</source>
    <translation>sáquelo de la carpeta de la campaña y guarde otra vez</translation>
  </message>
  <message>
    <source>name the survey that shall go on</source>
    <translation>indique la campaña que debe seguir</translation>
  </message>
  <message>
    <source>no MCP3008 answers on the SPI bus (it gave {reply})</source>
    <translation>ningún MCP3008 responde en el bus SPI (dio {reply})</translation>
  </message>
  <message>
    <source>no calibration</source>
    <translation>sin calibración</translation>
  </message>
  <message>
    <source>no complete answer within {limit} s</source>
    <translation>sin respuesta completa en {limit} s</translation>
  </message>
  <message>
    <source>no connection to the VNA at {address}: {error}</source>
    <translation>sin conexión con el VNA en {address}: {error}</translation>
  </message>
  <message>
    <source>no height measured yet</source>
    <translation>todavía no se ha medido la altura</translation>
  </message>
  <message>
    <source>no height: {reason}</source>
    <translation>sin altura: {reason}</translation>
  </message>
  <message>
    <source>no parameters have been set</source>
    <translation>no se han puesto parámetros</translation>
  </message>
  <message>
    <source>no survey is measuring (the control is {state})</source>
    <translation>ninguna campaña está midiendo (el control está en {state})</translation>
  </message>
  <message>
    <source>no survey is open</source>
    <translation>no hay campaña abierta</translation>
  </message>
  <message>
    <source>no survey is paused (the control is {state})</source>
    <translation>no hay campaña en pausa (el control está en {state})</translation>
  </message>
  <message>
    <source>no survey is running</source>
    <translation>no hay campaña en marcha</translation>
  </message>
  <message>
    <source>no sweep is configured</source>
    <translation>no hay barrido configurado</translation>
  </message>
  <message>
    <source>nobody else may move them during a survey</source>
    <translation>nadie más puede moverlos durante una campaña</translation>
  </message>
  <message>
    <source>nobody else may set it up during a survey</source>
    <translation>nadie más puede configurarlo durante una campaña</translation>
  </message>
  <message>
    <source>nobody may operate it by hand during a survey</source>
    <translation>nadie puede manejarlo durante una campaña</translation>
  </message>
  <message>
    <source>not connected</source>
    <translation>sin conexión</translation>
  </message>
  <message>
    <source>not homed</source>
    <translation>sin origen</translation>
  </message>
  <message>
    <source>not permitted</source>
    <translation>no permitido</translation>
  </message>
  <message>
    <source>not resumed: {reason}</source>
    <translation>no se siguió: {reason}</translation>
  </message>
  <message>
    <source>nothing was measured</source>
    <translation>no se midió nada</translation>
  </message>
  <message>
    <source>nothing was stored</source>
    <translation>no se guardó nada</translation>
  </message>
  <message>
    <source>nothing was stored, check the disk</source>
    <translation>no se guardó nada, compruebe el disco</translation>
  </message>
  <message>
    <source>on request</source>
    <translation>a petición</translation>
  </message>
  <message>
    <source>only {free} MB are free on the disk</source>
    <translation>solo quedan {free} MB libres en el disco</translation>
  </message>
  <message>
    <source>paused: {reason}</source>
    <translation>en pausa: {reason}</translation>
  </message>
  <message>
    <source>pausing after this sample</source>
    <translation>pausa tras esta medida</translation>
  </message>
  <message>
    <source>permission denied</source>
    <translation>permiso denegado</translation>
  </message>
  <message>
    <source>profile {place} is missing</source>
    <translation>falta en el perfil {place}</translation>
  </message>
  <message>
    <source>profile {place} is unknown</source>
    <translation>el perfil tiene un valor desconocido, {place}</translation>
  </message>
  <message>
    <source>profile {place} is {found}</source>
    <translation>en el perfil, {place} es {found}</translation>
  </message>
  <message>
    <source>profile {place} must be a group of values, but is {found}</source>
    <translation>el perfil {place} debe ser un grupo de valores, pero es {found}</translation>
  </message>
  <message>
    <source>pulses without real-time scheduling, refused: {refused}</source>
    <translation>pulsos sin planificación de tiempo real, rechazado: {refused}</translation>
  </message>
  <message>
    <source>reading the VNA's calibration failed {count} times: {reason}</source>
    <translation>la lectura de la calibración del VNA falló {count} veces: {reason}</translation>
  </message>
  <message>
    <source>ready for {count} traces</source>
    <translation>preparado para {count} trazas</translation>
  </message>
  <message>
    <source>resume the survey to home it</source>
    <translation>siga con la campaña para llevarlo a su origen</translation>
  </message>
  <message>
    <source>resume when it is mended, or stop</source>
    <translation>siga cuando esté arreglado, o pare</translation>
  </message>
  <message>
    <source>resume_survey goes on with it later</source>
    <translation>se puede seguir con ella más tarde</translation>
  </message>
  <message>
    <source>resuming with {pending} of {planned} traces to go</source>
    <translation>se sigue con {pending} de {planned} trazas por medir</translation>
  </message>
  <message>
    <source>save it again</source>
    <translation>guárdelo de nuevo</translation>
  </message>
  <message>
    <source>service [{service}] unavailable</source>
    <translation>el servicio [{service}] no está disponible</translation>
  </message>
  <message>
    <source>the survey in {folder} holds trace {index}, its parameters give only {planned}: its survey.json is not that of its traces</source>
    <translation>la campaña de {folder} contiene la traza {index}, sus parámetros dan solo {planned}: su survey.json no es el de sus trazas</translation>
  </message>
  <message>
    <source>the call was given up</source>
    <translation>la llamada fue abandonada</translation>
  </message>
  <message>
    <source>service {service} could not be called: {error}</source>
    <translation>el servicio {service} no se pudo llamar: {error}</translation>
  </message>
  <message>
    <source>service {service} did not answer within {limit} s</source>
    <translation>el servicio {service} no respondió en {limit} s</translation>
  </message>
  <message>
    <source>set it, or every time in the recordings would be wrong</source>
    <translation>póngalo en hora, o todas las horas de las grabaciones estarían mal</translation>
  </message>
  <message>
    <source>set the parameters of a survey</source>
    <translation>ponga los parámetros de una campaña</translation>
  </message>
  <message>
    <source>set them, then start</source>
    <translation>póngalos y después inicie</translation>
  </message>
  <message>
    <source>setting up the VNA failed {count} times: {reason}</source>
    <translation>la configuración del VNA falló {count} veces: {reason}</translation>
  </message>
  <message>
    <source>setting up the VNA was given up: {reason}</source>
    <translation>se renunció a configurar el VNA: {reason}</translation>
  </message>
  <message>
    <source>stop it and start anew</source>
    <translation>párela y empiece de nuevo</translation>
  </message>
  <message>
    <source>stop it first</source>
    <translation>párela antes</translation>
  </message>
  <message>
    <source>stop it or wait for its end</source>
    <translation>párela o espere a que termine</translation>
  </message>
  <message>
    <source>stopped at {coordinate} {unit}, before the target {target} {unit_too}</source>
    <translation>parado en {coordinate} {unit}, antes del destino {target} {unit_too}</translation>
  </message>
  <message>
    <source>stopped on request</source>
    <translation>parada a petición</translation>
  </message>
  <message>
    <source>target {target} {unit} lies outside the axis, {low} to {high} {unit_too}</source>
    <translation>el destino {target} {unit} está fuera del eje, de {low} a {high} {unit_too}</translation>
  </message>
  <message>
    <source>stopping: storing what has been measured</source>
    <translation>parando: se guarda lo medido</translation>
  </message>
  <message>
    <source>survey {survey} was still open and is closed as interrupted</source>
    <translation>la campaña {survey} aún estaba abierta y se cierra como interrumpida</translation>
  </message>
  <message>
    <source>the SPI bus failed: {error}</source>
    <translation>falló el bus SPI: {error}</translation>
  </message>
  <message>
    <source>the VNA accepted {accepted} instead of {asked}</source>
    <translation>el VNA aceptó {accepted} en vez de {asked}</translation>
  </message>
  <message>
    <source>the VNA at {address} is now {identity} and was {former}</source>
    <translation>el VNA de {address} es ahora {identity} y era {former}</translation>
  </message>
  <message>
    <source>the VNA is not calibrated</source>
    <translation>el VNA no está calibrado</translation>
  </message>
  <message>
    <source>the VNA is not connected</source>
    <translation>el VNA no está conectado</translation>
  </message>
  <message>
    <source>the VNA measured {setting} instead of {asked}</source>
    <translation>el VNA midió {setting} en vez de {asked}</translation>
  </message>
  <message>
    <source>the VNA says it is {identity}</source>
    <translation>el VNA dice que es {identity}</translation>
  </message>
  <message>
    <source>the VNA's calibration status is {status} ({meaning})</source>
    <translation>el estado de calibración del VNA es {status} ({meaning})</translation>
  </message>
  <message>
    <source>the VNA's frequencies are no longer those of this survey</source>
    <translation>las frecuencias del VNA ya no son las de esta campaña</translation>
  </message>
  <message>
    <source>the VNA's number of points changed to {points} by itself</source>
    <translation>el número de puntos del VNA cambió solo a {points}</translation>
  </message>
  <message>
    <source>short circuit</source>
    <translation>cortocircuito</translation>
  </message>
  <message>
    <source>profile {place} has too many digits for a number of type float</source>
    <translation>el perfil {place} tiene demasiadas cifras para un número de tipo float</translation>
  </message>
  <message>
    <source>the VNA's sweep failed {count} times: {reason}</source>
    <translation>el barrido del VNA falló {count} veces: {reason}</translation>
  </message>
  <message>
    <source>the VNA's sweep was given up: {reason}</source>
    <translation>se renunció al barrido del VNA: {reason}</translation>
  </message>
  <message>
    <source>the antenna height could not be measured: {reason}</source>
    <translation>no se pudo medir la altura de las antenas: {reason}</translation>
  </message>
  <message>
    <source>the axes moved during the sweep at point {index}</source>
    <translation>los ejes se movieron durante el barrido en el punto {index}</translation>
  </message>
  <message>
    <source>the axes stand at {position} instead of {planned} before the sweep at point {index}</source>
    <translation>los ejes están en {position} en vez de {planned} antes del barrido en el punto {index}</translation>
  </message>
  <message>
    <source>the axes were told to stop instead</source>
    <translation>en su lugar se ordenó parar a los ejes</translation>
  </message>
  <message>
    <source>the axis is busy with another motion</source>
    <translation>el eje está ocupado con otro movimiento</translation>
  </message>
  <message>
    <source>the axis is not homed</source>
    <translation>el eje no tiene origen</translation>
  </message>
  <message>
    <source>the calibration is low: the VNA is more than 10 degrees warmer or colder than then</source>
    <translation>la calibración es baja: el VNA está más de 10 grados más caliente o más frío que entonces</translation>
  </message>
  <message>
    <source>the calibration is moderate: its power level was another</source>
    <translation>la calibración es media: su potencia era otra</translation>
  </message>
  <message>
    <source>the calibration is moderate: the VNA is more than 5 degrees warmer or colder than then</source>
    <translation>la calibración es media: el VNA está más de 5 grados más caliente o más frío que entonces</translation>
  </message>
  <message>
    <source>the computer's clock says {time}</source>
    <translation>el reloj del ordenador dice {time}</translation>
  </message>
  <message>
    <source>the connection was closed by the other side</source>
    <translation>el otro lado cerró la conexión</translation>
  </message>
  <message>
    <source>the data block is cut: {arrived} of {announced} announced bytes arrived</source>
    <translation>el bloque de datos está cortado: llegaron {arrived} de {announced} bytes anunciados</translation>
  </message>
  <message>
    <source>the disk did not finish within {limit} s ({reason})</source>
    <translation>el disco no terminó en {limit} s ({reason})</translation>
  </message>
  <message>
    <source>the disk did not take everything within {limit} s</source>
    <translation>el disco no aceptó todo en {limit} s</translation>
  </message>
  <message>
    <source>the disk is full</source>
    <translation>el disco está lleno</translation>
  </message>
  <message>
    <source>the disk is read-only</source>
    <translation>el disco es de solo lectura</translation>
  </message>
  <message>
    <source>the disk is too slow</source>
    <translation>el disco es demasiado lento</translation>
  </message>
  <message>
    <source>the disk of {path} cannot be asked: {error}</source>
    <translation>no se puede consultar el disco de {path}: {error}</translation>
  </message>
  <message>
    <source>the disk quota is used up</source>
    <translation>la cuota de disco está agotada</translation>
  </message>
  <message>
    <source>the endstop is still pressed {length} {unit} away from it: it is stuck closed or the motor does not turn</source>
    <translation>el final de carrera sigue pulsado a {length} {unit} de él: está atascado cerrado o el motor no gira</translation>
  </message>
  <message>
    <source>the endstop says where this axis has its zero</source>
    <translation>el final de carrera dice dónde tiene este eje su cero</translation>
  </message>
  <message>
    <source>the endstop stayed pressed for {length} {unit}: it is stuck closed, short-circuited, or the motor does not turn</source>
    <translation>el final de carrera siguió pulsado durante {length} {unit}: está atascado cerrado, en cortocircuito, o el motor no gira</translation>
  </message>
  <message>
    <source>the endstop switched {length} {unit} from where the carriage had backed off by {backoff} {unit_too}: it does not switch at one place</source>
    <translation>el final de carrera conmutó a {length} {unit} de donde el carro se había retirado {backoff} {unit_too}: no conmuta en un solo sitio</translation>
  </message>
  <message>
    <source>the endstop was not reached within {length} {unit}: it is stuck open, unplugged, or the motor does not turn</source>
    <translation>no se alcanzó el final de carrera en {length} {unit}: está atascado abierto, desenchufado, o el motor no gira</translation>
  </message>
  <message>
    <source>the endstop was pressed at {coordinate} {unit}, where it should be open: steps were lost or the switch is stuck</source>
    <translation>el final de carrera se pulsó en {coordinate} {unit}, donde debe estar abierto: se perdieron pasos o el interruptor está atascado</translation>
  </message>
  <message>
    <source>the former survey has not ended within {limit} s: {reason}</source>
    <translation>la campaña anterior no terminó en {limit} s: {reason}</translation>
  </message>
  <message>
    <source>the height readings scatter by {spread} m (from {lowest} to {highest} m)</source>
    <translation>las lecturas de altura se dispersan en {spread} m (de {lowest} a {highest} m)</translation>
  </message>
  <message>
    <source>the height sensor is stuck: its last {count} readings are the very same, without any noise</source>
    <translation>el sensor de altura está atascado: sus últimas {count} lecturas son idénticas, sin ruido alguno</translation>
  </message>
  <message>
    <source>the height sensor is stuck: {count} of {all} readings are {rail}, the end of the converter's scale ({reason})</source>
    <translation>el sensor de altura está atascado: {count} de {all} lecturas son {rail}, el extremo de la escala del convertidor ({reason})</translation>
  </message>
  <message>
    <source>the height sensor reads {distance} m</source>
    <translation>el sensor de altura lee {distance} m</translation>
  </message>
  <message>
    <source>the height sensor's node is being shut down</source>
    <translation>el nodo del sensor de altura se está apagando</translation>
  </message>
  <message>
    <source>the imaginary part of the trace is a copy of its real part</source>
    <translation>la parte imaginaria de la traza es copia de la real</translation>
  </message>
  <message>
    <source>the instrument gave the very same data as for the sweep before</source>
    <translation>el instrumento dio exactamente los datos del barrido anterior</translation>
  </message>
  <message>
    <source>the last motion was slowed down by {count} late edges, the latest pulse by {late} ms: this computer does too much else</source>
    <translation>el último movimiento se frenó por {count} flancos tardíos, el más tardío de {late} ms: este ordenador hace demasiadas cosas más</translation>
  </message>
  <message>
    <source>the parameters cannot be changed</source>
    <translation>los parámetros no se pueden cambiar</translation>
  </message>
  <message>
    <source>the paused survey is {survey}, not {other}</source>
    <translation>la campaña en pausa es {survey}, no {other}</translation>
  </message>
  <message>
    <source>the process that makes the pulses made no step for {limit} s and was ended</source>
    <translation>el proceso que hace los pulsos no dio ningún paso en {limit} s y se terminó</translation>
  </message>
  <message>
    <source>the profile {path} cannot be deleted: {error}</source>
    <translation>el perfil {path} no se puede eliminar: {error}</translation>
  </message>
  <message>
    <source>the profile {path} cannot be read: {error}</source>
    <translation>el perfil {path} no se puede leer: {error}</translation>
  </message>
  <message>
    <source>the profile {path} cannot be written: {error}</source>
    <translation>el perfil {path} no se puede escribir: {error}</translation>
  </message>
  <message>
    <source>the profiles in {path} cannot be listed: {error}</source>
    <translation>los perfiles en {path} no se pueden listar: {error}</translation>
  </message>
  <message>
    <source>the real</source>
    <translation>el robot real</translation>
  </message>
  <message>
    <source>the receiver may be overloaded or the calibration be another setup's</source>
    <translation>el receptor puede estar saturado o la calibración ser de otro montaje</translation>
  </message>
  <message>
    <source>the recordings could not be finished: {reason}</source>
    <translation>las grabaciones no se pudieron terminar: {reason}</translation>
  </message>
  <message>
    <source>the sensor is off or unplugged</source>
    <translation>el sensor está apagado o desenchufado</translation>
  </message>
  <message>
    <source>the storage is shutting down</source>
    <translation>el almacenamiento se está apagando</translation>
  </message>
  <message>
    <source>the survey goes on by itself when every node is back</source>
    <translation>la campaña sigue sola cuando vuelvan todos los nodos</translation>
  </message>
  <message>
    <source>the survey in {folder} cannot go on, its survey.json is not whole: {error}</source>
    <translation>la campaña de {folder} no puede seguir, su survey.json no está entero: {error}</translation>
  </message>
  <message>
    <source>the survey in {folder} was measured by {kind} robot</source>
    <translation>la campaña de {folder} se midió con {kind}</translation>
  </message>
  <message>
    <source>the survey in {folder} was measured with {name} {former} of the {axis} axis, which is {present} now: its points would lie elsewhere</source>
    <translation>la campaña de {folder} se midió con {name} {former} del eje {axis}, que ahora es {present}: sus puntos quedarían en otro sitio</translation>
  </message>
  <message>
    <source>the survey is not ended yet: {reason}</source>
    <translation>la campaña no ha terminado todavía: {reason}</translation>
  </message>
  <message>
    <source>the survey needs {needed} MB and {reserve} MB are kept in reserve, but the disk of {path} has only {free} MB free</source>
    <translation>la campaña necesita {needed} MB y se guardan {reserve} MB de reserva, pero el disco de {path} solo tiene {free} MB libres</translation>
  </message>
  <message>
    <source>the survey's folder holds {stored} of {planned} traces</source>
    <translation>la carpeta de la campaña tiene {stored} de {planned} trazas</translation>
  </message>
  <message>
    <source>the sweep also failed with: {reason}</source>
    <translation>el barrido falló además con: {reason}</translation>
  </message>
  <message>
    <source>the sweep of {points} points did not end within {limit} s</source>
    <translation>el barrido de {points} puntos no terminó en {limit} s</translation>
  </message>
  <message>
    <source>the sweep took {duration} s, usual are {usual} s</source>
    <translation>el barrido tardó {duration} s, lo normal son {usual} s</translation>
  </message>
  <message>
    <source>the sweep was repeated {times}: {reason}</source>
    <translation>el barrido se repitió {times}: {reason}</translation>
  </message>
  <message>
    <source>the zero of this axis is not known: it has no endstop, and nothing says where it stopped last</source>
    <translation>no se conoce el cero de este eje: no tiene final de carrera y nada dice dónde paró la última vez</translation>
  </message>
  <message>
    <source>the {axis} axis did not end its move to {target} {unit} within {limit} s</source>
    <translation>el eje {axis} no acabó en {limit} s su movimiento a {target} {unit}</translation>
  </message>
  <message>
    <source>the {axis} axis did not reach {target} {unit}: {reason}</source>
    <translation>el eje {axis} no llegó a {target} {unit}: {reason}</translation>
  </message>
  <message>
    <source>the {axis} axis has lost its zero</source>
    <translation>el eje {axis} ha perdido su cero</translation>
  </message>
  <message>
    <source>the {axis} axis is not homed: its position is unknown</source>
    <translation>el eje {axis} no tiene origen: no se conoce su posición</translation>
  </message>
  <message>
    <source>the {axis} axis is silent: nothing on {topic} for {limit} s</source>
    <translation>el eje {axis} calla: nada en {topic} desde hace {limit} s</translation>
  </message>
  <message>
    <source>the {axis} axis stands at {coordinate} {unit} instead of {target} {unit_too}</source>
    <translation>el eje {axis} está en {coordinate} {unit} en vez de {target} {unit_too}</translation>
  </message>
  <message>
    <source>there is nothing to pause</source>
    <translation>no hay nada que poner en pausa</translation>
  </message>
  <message>
    <source>there is nothing to stop</source>
    <translation>no hay nada que parar</translation>
  </message>
  <message>
    <source>this is a file, no folder</source>
    <translation>esto es un archivo, no una carpeta</translation>
  </message>
  <message>
    <source>this is a folder, no file</source>
    <translation>esto es una carpeta, no un archivo</translation>
  </message>
  <message>
    <source>timed out</source>
    <translation>tiempo agotado</translation>
  </message>
  <message>
    <source>timeout exceeded while waiting for service {service}</source>
    <translation>tiempo agotado esperando el servicio {service}</translation>
  </message>
  <message>
    <source>trace {index} could not be stored: {reason}</source>
    <translation>la traza {index} no se pudo guardar: {reason}</translation>
  </message>
  <message>
    <source>try again</source>
    <translation>inténtelo otra vez</translation>
  </message>
  <message>
    <source>turn the antennas to their mark and call the service set_zero</source>
    <translation>gire las antenas a su marca y llame al servicio set_zero</translation>
  </message>
  <message>
    <source>unable to connect to service: {reason}</source>
    <translation>no se puede conectar con el servicio: {reason}</translation>
  </message>
  <message>
    <source>what is in the folder must belong to this user, and its file system know hard links</source>
    <translation>lo que hay en la carpeta debe ser de este usuario, y su sistema de archivos admitir enlaces duros</translation>
  </message>
  <message>
    <source>{action} at {address} failed: {reason}</source>
    <translation>{action} en {address} falló: {reason}</translation>
  </message>
  <message>
    <source>{action} failed: the link to {address} is closed</source>
    <translation>{action} falló: la conexión con {address} está cerrada</translation>
  </message>
  <message>
    <source>{axis} axis does NOT answer: {reason}</source>
    <translation>el eje {axis} NO responde: {reason}</translation>
  </message>
  <message>
    <source>{axis} axis: stopping</source>
    <translation>eje {axis}: parando</translation>
  </message>
  <message>
    <source>{count} jobs were waiting for the disk for {limit} s</source>
    <translation>{count} tareas esperaron al disco durante {limit} s</translation>
  </message>
  <message>
    <source>{count} of {all} points in a row are the very same number</source>
    <translation>{count} de {all} puntos seguidos son el mismo número</translation>
  </message>
  <message>
    <source>{count} traces stored</source>
    <translation>{count} trazas guardadas</translation>
  </message>
  <message>
    <source>{count} traces were not stored within {limit} s</source>
    <translation>{count} trazas no se guardaron en {limit} s</translation>
  </message>
  <message>
    <source>{lost} and did not come back within {limit} s</source>
    <translation>{lost} y no volvió en {limit} s</translation>
  </message>
  <message>
    <source>{lost}, {count} times with no trace in between</source>
    <translation>{lost}, {count} veces sin ninguna traza entre ellas</translation>
  </message>
  <message>
    <source>{missing} of {all} numbers of the instrument are not finite</source>
    <translation>{missing} de {all} números del instrumento no son finitos</translation>
  </message>
  <message>
    <source>{name} cannot be the name of a profile</source>
    <translation>{name} no puede ser el nombre de un perfil</translation>
  </message>
  <message>
    <source>{nodes} do not answer</source>
    <translation>{nodes} no responden</translation>
  </message>
  <message>
    <source>{nodes} does not answer</source>
    <translation>{nodes} no responde</translation>
  </message>
  <message>
    <source>{nodes} started anew</source>
    <translation>{nodes} arrancó de nuevo</translation>
  </message>
  <message>
    <source>{nodes} went silent</source>
    <translation>{nodes} dejó de responder</translation>
  </message>
  <message>
    <source>{service}: {reason}</source>
    <translation>{service}: {reason}</translation>
  </message>
  <message>
    <source>{silent} went silent, {anew} started anew</source>
    <translation>{silent} dejó de responder, {anew} arrancó de nuevo</translation>
  </message>
  <message>
    <source>{stored} of {planned} traces in {folder}</source>
    <translation>{stored} de {planned} trazas en {folder}</translation>
  </message>
  <message>
    <source>{stored} traces in {folder}</source>
    <translation>{stored} trazas en {folder}</translation>
  </message>
  <message>
    <source>{what} could not be read again from {path}: {reason}</source>
    <translation>{what} no se pudo leer otra vez de {path}: {reason}</translation>
  </message>
  <message>
    <source>{what} could not be written to {path}: {reason}</source>
    <translation>{what} no se pudo escribir en {path}: {reason}</translation>
  </message>
</context>
<context>
  <name>SurveyState</name>
  <message>
    <source>CHECKING</source>
    <translation>COMPROBANDO</translation>
  </message>
  <message>
    <source>CONFIGURED</source>
    <translation>CONFIGURADO</translation>
  </message>
  <message>
    <source>FAILED</source>
    <translation>FALLIDA</translation>
  </message>
  <message>
    <source>FINISHED</source>
    <translation>TERMINADA</translation>
  </message>
  <message>
    <source>HOMING</source>
    <translation>BUSCANDO ORIGEN</translation>
  </message>
  <message>
    <source>IDLE</source>
    <translation>EN ESPERA</translation>
  </message>
  <message>
    <source>PAUSED</source>
    <translation>EN PAUSA</translation>
  </message>
  <message>
    <source>PAUSING</source>
    <translation>PAUSANDO</translation>
  </message>
  <message>
    <source>STOPPED</source>
    <translation>PARADA</translation>
  </message>
  <message>
    <source>STOPPING</source>
    <translation>PARANDO</translation>
  </message>
  <message>
    <source>SURVEYING</source>
    <translation>MIDIENDO</translation>
  </message>
</context>
<context>
  <name>TopBar</name>
  <message>
    <source>SIMULATED</source>
    <translation>SIMULADO</translation>
  </message>
  <message>
    <source>STOP</source>
    <translation>PARAR</translation>
  </message>
  <message>
    <source>The ROS master does not answer: the robot may still move. Waiting for it.</source>
    <translation>El maestro de ROS no responde: el robot puede seguir moviéndose. Esperándolo.</translation>
  </message>
  <message>
    <source>The VNA is in trouble: {detail}</source>
    <translation>El VNA tiene problemas: {detail}</translation>
  </message>
  <message>
    <source>main_control is not heard. It starts with: roslaunch gpr20 survey.launch</source>
    <translation>No se oye main_control. Se arranca con: roslaunch gpr20 survey.launch</translation>
  </message>
  <message>
    <source>main_control not heard for {seconds} s: the robot may still move. Waiting for it.</source>
    <translation>No se oye main_control desde hace {seconds} s: el robot puede seguir moviéndose. Esperándolo.</translation>
  </message>
  <message>
    <source>main_control was started anew: the survey is INTERRUPTED. SURVEYS resumes it.</source>
    <translation>main_control se reinició: la campaña está INTERRUMPIDA. Se reanuda en CAMPAÑAS.</translation>
  </message>
</context>
</TS>

<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE TS>
<TS version="2.1" language="es" sourcelanguage="en">
<context>
  <name>ControlText</name>
  <message>
    <source>INCOMPLETE: {stored} of {planned} planned traces are stored, {failed} failed, {missing} not visited</source>
    <translation>INCOMPLETA: {stored} de {planned} trazas previstas guardadas, {failed} fallidas, {missing} sin visitar</translation>
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
    <source>homing the axes</source>
    <translation>llevando los ejes a su origen</translation>
  </message>
  <message>
    <source>measuring</source>
    <translation>midiendo</translation>
  </message>
  <message>
    <source>pausing after this sample</source>
    <translation>pausa tras esta medida</translation>
  </message>
</context>
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
    <source>A survey has at most {most} traces</source>
    <translation>Una campaña tiene como máximo {most} trazas</translation>
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
  <message>
    <source>Save profile as</source>
    <translation>Guardar el perfil como</translation>
  </message>
  <message>
    <source>a new name: letters, digits, blanks, - and _</source>
    <translation>un nombre nuevo: letras, cifras, espacios, - y _</translation>
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
</context>
</TS>

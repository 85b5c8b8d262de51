<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE TS><TS version="2.0" language="es" sourcelanguage="en">
<context>
  <name>MapCanvas</name>
  <message>
    <source>Y mm</source>
    <translation>Y mm</translation>
  </message>
  <message>
    <source>X mm</source>
    <translation>X mm</translation>
  </message>
  <message>
    <source>No survey yet: the map appears when one starts.</source>
    <translation>Todavía no hay campaña: el mapa aparece cuando empieza una.</translation>
  </message>
</context>
<context>
  <name>MapView</name>
  <message>
    <source>no trace to show</source>
    <translation>no hay traza que mostrar</translation>
  </message>
  <message>
    <source>Next not done</source>
    <translation>Siguiente sin hacer</translation>
  </message>
  <message>
    <source>Depth mm</source>
    <translation>Profundidad mm</translation>
  </message>
  <message>
    <source>Delay ns</source>
    <translation>Retardo ns</translation>
  </message>
  <message>
    <source>Level dB</source>
    <translation>Nivel dB</translation>
  </message>
  <message>
    <source>Touch a stop to see its trace.</source>
    <translation>Toque un punto para ver su traza.</translation>
  </message>
  <message>
    <source>Antenna</source>
    <translation>Antena</translation>
  </message>
  <message>
    <source>X {x:g} mm, Y {y:g} mm: {state}</source>
    <translation>X {x:g} mm, Y {y:g} mm: {state}</translation>
  </message>
  <message>
    <source>Done</source>
    <translation>Hecho</translation>
  </message>
  <message>
    <source>Partly</source>
    <translation>En parte</translation>
  </message>
  <message>
    <source>Missing</source>
    <translation>Falta</translation>
  </message>
  <message>
    <source>Failed</source>
    <translation>Fallido</translation>
  </message>
  <message>
    <source>Antenna {rotation:g}°</source>
    <translation>Antena {rotation:g}°</translation>
  </message>
</context>
<context>
  <name>RadarControls</name>
  <message>
    <source>Background
removed</source>
    <translation>Fondo
quitado</translation>
  </message>
  <message>
    <source>Background
kept</source>
    <translation>Fondo
incluido</translation>
  </message>
  <message>
    <source>Permittivity</source>
    <translation>Permitividad</translation>
  </message>
  <message>
    <source>Gain</source>
    <translation>Ganancia</translation>
  </message>
  <message>
    <source>{value:g} dB/ns</source>
    <translation>{value:g} dB/ns</translation>
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
    <source>Antenna
{rotation:g}°</source>
    <translation>Antena
{rotation:g}°</translation>
  </message>
</context>
<context>
  <name>RadarView</name>
  <message>
    <source>Line</source>
    <translation>Línea</translation>
  </message>
  <message>
    <source>Depth mm</source>
    <translation>Profundidad mm</translation>
  </message>
  <message>
    <source>Delay ns</source>
    <translation>Retardo ns</translation>
  </message>
  <message>
    <source>Level dB</source>
    <translation>Nivel dB</translation>
  </message>
  <message>
    <source>Level</source>
    <translation>Nivel</translation>
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
    <source>Last trace</source>
    <translation>Última traza</translation>
  </message>
  <message>
    <source>{count} of {planned} traces</source>
    <translation>{count} de {planned} trazas</translation>
  </message>
  <message>
    <source>cannot be shown: {count}</source>
    <translation>no se pueden mostrar: {count}</translation>
  </message>
  <message>
    <source>background is kept until there are {count} traces</source>
    <translation>el fondo se incluye hasta que haya {count} trazas</translation>
  </message>
  <message>
    <source>Grey was not measured. No echo does not mean no mine.</source>
    <translation>Gris: no medido. Sin eco no significa sin mina.</translation>
  </message>
  <message>
    <source>Back to the running survey</source>
    <translation>Volver a la campaña en curso</translation>
  </message>
  <message>
    <source>SIMULATED</source>
    <translation>SIMULADO</translation>
  </message>
  <message>
    <source>no height was measured: depth is not known</source>
    <translation>no se midió la altura: no se conoce la profundidad</translation>
  </message>
  <message>
    <source>Line at Y {y:g} mm</source>
    <translation>Línea en Y {y:g} mm</translation>
  </message>
  <message>
    <source>Slice at depth {depth:.0f} mm</source>
    <translation>Corte a {depth:.0f} mm de profundidad</translation>
  </message>
  <message>
    <source>PAST SURVEY {name}</source>
    <translation>CAMPAÑA PASADA {name}</translation>
  </message>
</context>
<context>
  <name>PastSurveysView</name>
  <message>
    <source>Started (UTC)</source>
    <translation>Inicio (UTC)</translation>
  </message>
  <message>
    <source>Coverage</source>
    <translation>Cobertura</translation>
  </message>
  <message>
    <source>Traces</source>
    <translation>Trazas</translation>
  </message>
  <message>
    <source>Show in RADAR</source>
    <translation>Ver en RADAR</translation>
  </message>
  <message>
    <source>Resume</source>
    <translation>Reanudar</translation>
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
    <source>complete</source>
    <translation>completa</translation>
  </message>
  <message>
    <source>INCOMPLETE</source>
    <translation>INCOMPLETA</translation>
  </message>
  <message>
    <source>running</source>
    <translation>en curso</translation>
  </message>
  <message>
    <source>CANNOT BE READ</source>
    <translation>ILEGIBLE</translation>
  </message>
  <message>
    <source>Touch a survey.</source>
    <translation>Toque una campaña.</translation>
  </message>
  <message>
    <source>simulated</source>
    <translation>simulada</translation>
  </message>
  <message>
    <source>It has not ended properly.</source>
    <translation>No terminó correctamente.</translation>
  </message>
</context>
</TS>

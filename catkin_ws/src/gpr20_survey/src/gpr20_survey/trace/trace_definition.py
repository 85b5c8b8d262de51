"""The definition of gpr20_msgs/Trace, for recordings that are written without ROS."""

TRACE_DEFINITION = f"""\
std_msgs/Header header
string format
string survey_id
string sample_id
uint32 index
time timestamp
float64 x_coord_mm
float64 y_coord_mm
float64 z_coord_deg
float64 antennae_height_m
float64[] frequency_hz
float64[] s21_real
float64[] s21_imag
time sweep_started
time sweep_ended
string[] quality
float64 if_bandwidth_hz
int32 averages
string output_power
AuxValue[] aux
uint32[3] zero_epochs
time[3] zero_times

{"=" * 80}
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id

{"=" * 80}
MSG: gpr20_msgs/AuxValue
string name
float64 value
string unit
time stamp
"""
"""Its types behind it, as a recording holds them; the checksum is `trace_message.MD5SUM`."""

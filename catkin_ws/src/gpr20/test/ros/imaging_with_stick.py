#!/usr/bin/env python3
"""The imaging node, on a computer where a folder counts as a USB stick."""

import json
from pathlib import Path

import rospy

from gpr20_common.high.node import run_device
from gpr20_imaging.high.imaging_node import NODE, ImagingNode
from gpr20_imaging.low.usb_volumes import UsbVolumes
from gpr20_imaging.mid.imaging_parameters import ImagingParameters

stick = Path(rospy.myargv()[1])
stick.mkdir()
device = {"name": "sdb1", "label": "STICK", "tran": "usb", "mountpoint": str(stick)}
volumes = UsbVolumes(lambda: json.dumps({"blockdevices": [device]}), (stick.parent,))
run_device(NODE, ImagingParameters, lambda found: ImagingNode(found, volumes))

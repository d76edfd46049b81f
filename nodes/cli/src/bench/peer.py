"""PyPI's mcap writer under the load of `fdm bench recorder`: peer.py FILE SECONDS paced|flood IMU_BYTES FRAME_BYTES."""
import json
import os
import resource
import sys
import time

from mcap.writer import Writer

file, seconds, pace, imu_size, frame_size = sys.argv[1], float(sys.argv[2]), sys.argv[3], *map(int, sys.argv[4:6])
imu, frame = bytes(imu_size), os.urandom(frame_size)
with open(file, "wb") as stream:
    writer = Writer(stream)
    writer.start("ros2", "peer")
    schemas = [writer.register_schema(n, "ros2msg", b"") for n in ("sensor_msgs/msg/Imu", "sensor_msgs/msg/CompressedImage")]
    channels = [writer.register_channel(t, "cdr", s) for t, s in zip(("/imu", "/frame"), schemas)]
    sent, late = [0, 0], 0.0
    begin = time.monotonic()
    while (now := time.monotonic() - begin) < seconds:
        if pace == "flood":
            for _ in range(1000):
                writer.add_message(channels[0], int(now * 1e9), imu, int(now * 1e9))
                sent[0] += 1
            continue
        for topic, hz, data in ((0, 2000.0, imu), (1, 30.0, frame)):
            while sent[topic] < now * hz:
                late = max(late, now - sent[topic] / hz)
                writer.add_message(channels[topic], int(now * 1e9), data, int(now * 1e9), sent[topic])
                sent[topic] += 1
        time.sleep(0.001)
    wall = time.monotonic() - begin
    writer.finish()
used = resource.getrusage(resource.RUSAGE_SELF)
cpu = used.ru_utime + used.ru_stime
print(json.dumps({"messages": sum(sent), "dropped": 0, "wall_s": wall, "cpu_s": cpu, "cpu_all_s": cpu, "peak_mib": used.ru_maxrss / 1024}))

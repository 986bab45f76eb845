#!/usr/bin/env python3
"""A force device as a client of `limberg run SCENE --device force-lcm`, as force_client.cpp, with Python's own library.

It sends a pose each millisecond and takes the forces that come back. The device here is a mass in a hand that comes
down and presses; put yours in place of `class Device`. What is sent and what comes: docs/devices.md.

    python3 force_client.py [SECONDS [PORT]]
"""
import select
import socket
import struct
import sys
import time
import zlib

GROUP, PORT = "239.255.76.67", int(sys.argv[2]) if len(sys.argv) > 2 else 7667
SECONDS = float(sys.argv[1]) if len(sys.argv) > 1 else 5.0
STYLUS, FORCE = 0x1B74A89741FFD76C, 0xA71B8302AF391D57  # fingerprints of the two types
STYLUS_FIELDS, FORCE_FIELDS = ">Qiqqqi3d4diI", ">Qiqqqiqqi3ddd3d3ddI"  # messages/*.lcm: big-endian, no padding


class Device:
    """150 g over the middle of the skin, in a hand of 0.3 N/mm that goes from 20 mm above it to 3 mm below."""
    z_mm, v_mm_s, force_N = 20.0, 0.0, 0.0

    def move(self, t_s):
        goal = 20 - 23 * min(1.0, t_s / 2)
        self.v_mm_s += (self.force_N + 0.3 * (goal - self.z_mm) - 0.005 * self.v_mm_s) * 1000 / 0.15 * 1e-3
        self.z_mm += self.v_mm_s * 1e-3


def packet(seq, t_ns, z_mm):
    """An LCM packet: magic, its number, the channel, the message with its checksum."""
    body = struct.pack(STYLUS_FIELDS, STYLUS, 1, seq, t_ns, -1, 501, 0, 0, z_mm, 1, 0, 0, 0, 0, 0)[:-4]
    return struct.pack(">4sI", b"LC02", seq) + b"LIMBERG_STYLUS\0" + body + struct.pack(">I", zlib.crc32(body))


sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
sock.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)  # stays on this machine
sock.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(GROUP) + socket.inet_aton("0.0.0.0"))
sock.bind((GROUP, PORT))
device, latency_us = Device(), []
seq, forces, touched, answered, most_N, heard = 0, 0, 0, -1, 0.0, 0
start = tick = time.monotonic_ns()
while tick - start < SECONDS * 1e9:
    device.move((tick - start) * 1e-9)
    sock.sendto(packet(seq, time.monotonic_ns(), device.z_mm), (GROUP, PORT))
    seq += 1
    while (left := tick + 1_000_000 - time.monotonic_ns()) > 0:
        if not select.select([sock], [], [], left * 1e-9)[0]:
            break
        magic, channel, body = (lambda p: (p[:4], *p[8:].split(b"\0", 1)))(sock.recv(65536))
        if magic != b"LC02" or channel != b"LIMBERG_FORCE" or len(body) != struct.calcsize(FORCE_FIELDS):
            continue
        m = struct.unpack(FORCE_FIELDS, body)  # t_device_ns 4, device_id 5, pose_seq 6, state 8, force_mN 9 to 11
        if m[0] != FORCE or m[5] != 501:
            continue
        heard, device.force_N = time.monotonic_ns(), 1e-3 * m[11]
        forces, touched, most_N = forces + 1, touched + (m[8] >= 2), max(most_N, device.force_N)
        if m[6] > answered:  # it may be answered again before the next one comes
            latency_us.append((heard - m[4]) * 1e-3)
        answered = m[6]
    if time.monotonic_ns() - heard > 20_000_000:  # nobody answers: let go
        device.force_N = 0.0
    tick = max(tick + 1_000_000, time.monotonic_ns())
latency_us.sort()
p = [latency_us[int(q * (len(latency_us) - 1))] if latency_us else 0 for q in (0.5, 0.99, 0.999)]
print(f"{seq} poses, {forces} forces, {touched} in contact, at most {most_N:.3f} N; "
      f"from pose to force p50 {p[0]:.0f}, p99 {p[1]:.0f}, p99.9 {p[2]:.0f} us")
sys.exit(0 if forces else 3)

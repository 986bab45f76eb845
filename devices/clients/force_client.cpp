// A force device as a client of `limberg run SCENE --device force-lcm`: it sends a pose each millisecond and takes the
// forces that come back. The device here is a mass in a hand that comes down and presses; put yours in place of
// `struct Device`. What is sent and what comes: docs/devices.md; force_client.py is the same in Python.
//
//   lcm-gen -x --cpp-std c++11 messages/stylus_t.lcm messages/force_t.lcm
//   g++ -std=c++17 -O2 force_client.cpp -llcm -o force_client && ./force_client [SECONDS [URL]]
#include <poll.h>
#include <sched.h>
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <lcm/lcm-cpp.hpp>
#include <vector>

#include "limberg_msg/force_t.hpp"
#include "limberg_msg/stylus_t.hpp"

namespace {

int64_t now_ns() {
  timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return int64_t(t.tv_sec) * 1000000000 + t.tv_nsec;
}

struct Device {  // 150 g at the middle of the skin, in a hand of 0.3 N/mm that goes from 20 mm above it to 3 mm below
  double z_mm = 20, v_mm_s = 0, force_N = 0;
  void move(double t_s) {
    const double goal = 20 - 23 * std::min(1.0, t_s / 2);
    v_mm_s += (force_N + 0.3 * (goal - z_mm) - 0.005 * v_mm_s) * 1000 / 0.15 * 1e-3;
    z_mm += v_mm_s * 1e-3;
  }
};

struct Client {
  Device device;
  int64_t heard_ns = 0, answered = -1, forces = 0, touched = 0;
  double most_N = 0;
  std::vector<double> latency_us;
  void on_force(const lcm::ReceiveBuffer*, const std::string&, const limberg_msg::force_t* m) {
    if (m->device_id != 500) return;
    device.force_N = 1e-3 * m->force_mN[2];
    heard_ns = now_ns(), ++forces, touched += m->state >= 2;
    most_N = std::max(most_N, device.force_N);
    if (m->pose_seq > answered) latency_us.push_back(1e-3 * double(heard_ns - m->t_device_ns));
    answered = m->pose_seq;  // it may be answered again before the next one comes
  }
};

}  // namespace

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 5;
  sched_param prompt{};
  prompt.sched_priority = 70;
  sched_setscheduler(0, SCHED_FIFO, &prompt);  // where it is allowed; LCM's own thread is then as prompt
  lcm::LCM lcm(argc > 2 ? argv[2] : "udpm://239.255.76.67:7667?ttl=0");
  if (!lcm.good()) return std::fprintf(stderr, "no LCM: ip route add 224.0.0.0/4 dev lo\n"), 2;
  Client client;
  lcm.subscribe("LIMBERG_FORCE", &Client::on_force, &client);
  limberg_msg::stylus_t pose{};
  pose.schema_version = 1, pose.t_device_ns = -1, pose.device_id = 500, pose.quat[0] = 1;
  const int64_t start = now_ns();
  for (int64_t tick = start; double(tick - start) * 1e-9 < seconds; tick = std::max(tick + 1000000, now_ns())) {
    client.device.move(double(tick - start) * 1e-9);
    pose.tip_mm[2] = client.device.z_mm, pose.t_host_ns = now_ns();
    lcm.publish("LIMBERG_STYLUS", &pose), ++pose.seq;
    for (int64_t left; (left = tick + 1000000 - now_ns()) > 0;) {
      pollfd p{lcm.getFileno(), POLLIN, 0};
      const timespec wait{0, long(left)};
      if (ppoll(&p, 1, &wait, nullptr) > 0) lcm.handle();
    }
    if (now_ns() - client.heard_ns > 20000000) client.device.force_N = 0;  // nobody answers: let go
  }
  std::vector<double>& l = client.latency_us;
  std::sort(l.begin(), l.end());
  const auto at = [&l](double p) { return l.empty() ? 0 : l[size_t(p * double(l.size() - 1))]; };
  std::printf(
      "%lld poses, %lld forces, %lld in contact, at most %.3f N; from pose to force p50 %.0f, p99 %.0f, p99.9 %.0f "
      "us\n",
      (long long)pose.seq, (long long)client.forces, (long long)client.touched, client.most_N, at(0.5), at(0.99),
      at(0.999));
  return client.forces > 0 ? 0 : 3;
}

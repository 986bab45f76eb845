// A laboratory's force device beside the program, as its people call it: the clients that are shipped, in C++ and in
// Python, against a session. Behaviour, never times.
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/app/cli.h"
#include "tests/own_port.h"

namespace test_cli_force {

class ForceClients : public Cli {
 protected:
  /// A session with the device, and the client beside it: what the client said, and how both ended.
  Outcome beside(const std::string& client, const std::string& json_file, const std::string& device) {
    Outcome session;
    std::thread program([&] {
      session = run("run " + scene_ + " --headless --seconds 6 --replace --record " + path("force.lcm") + " --device " +
                    device + " --json " + json_file);
    });
    const std::string said = path("client.txt");
    const int s = std::system(("sleep 1; " + client + " >" + said + " 2>&1 </dev/null").c_str());
    program.join();
    EXPECT_EQ(session.status, 0) << session.err;
    Outcome o;
    o.status = WIFEXITED(s) ? WEXITSTATUS(s) : 1000 + WTERMSIG(s);
    o.out = slurp(said);
    return o;
  }
  std::string scene_ = file("small.toml", small_scene());
};

struct Told {
  long poses = 0, forces = 0, touched = 0;
  double most_N = 0;
  explicit Told(const std::string& line) {
    std::sscanf(line.c_str(), "%ld poses, %ld forces, %ld in contact, at most %lf N", &poses, &forces, &touched,
                &most_N);
  }
};

TEST_F(ForceClients, InCppAndInPythonFeelTheSkin) {
  const int port = limberg::free_udp_port();
  const std::string url = limberg::udpm_here(port);
  const std::string clients[] = {
      limberg::binary_dir() + "/limberg_force_client 4 '" + url + "'",
      "python3 " + kSource + "/devices/clients/force_client.py 4 " + std::to_string(port),
  };
  for (const std::string& client : clients) {
    if (client.starts_with("python3") && std::system("python3 -c '' 2>/dev/null") != 0) continue;
    const Outcome o = beside(client, path("r.json"), "'force-lcm:" + url + "'");
    if (o.status == 2 || o.status == 3) GTEST_SKIP() << "multicast packets do not come back on this machine: " << o.out;
    ASSERT_EQ(o.status, 0) << o.out;
    std::printf("%s", o.out.c_str());
    const Told told(o.out);
    EXPECT_GT(told.poses, 500);
    EXPECT_GT(told.forces, 500);
    EXPECT_GT(told.touched, 50) << "its hand came down onto the skin";
    EXPECT_GT(told.most_N, 0.05);
    EXPECT_LT(told.most_N, 0.3 * 3) << "no more than the hand presses with";
    const auto r = nlohmann::json::parse(slurp(path("r.json")));
    EXPECT_EQ(int(r["device"]["events_lost"]), 0);
  }
  // What was recorded of such a session is replayed as any other.
  const Outcome o = run("replay " + path("force.lcm") + " --json " + path("replayed.json"));
  EXPECT_EQ(o.status, 0) << o.err;
}

TEST_F(ForceClients, WhatCannotBeIsRefused) {
  expect_refused("run " + scene_ + " --headless --seconds 1 --device 'force-lcm:udpm://239.255.76.67:7667?ttl=3'",
                 {"other machines", "ttl=0"});
  expect_refused("run " + scene_ + " --headless --seconds 1 --slow-motion --device force-lcm", {"--slow-motion"});
  expect_refused("run " + scene_ + " --headless --device force-lcm:force=1000", {"force=1000", "to 100"});
  expect_refused("run " + scene_ + " --headless --device force-lcm:udpm://239.255.76.67:7667?ttl=0,delay=x",
                 {"delay=x"});
  expect_refused("run " + scene_ + " --headless --device driver:/no/such.so", {"no such file", "limberg_driver.h"});
  expect_refused("devices --device driver:" + scene_, {"cannot be loaded"});
  expect_refused("devices --device driver:" + limberg::binary_dir() + "/drivers/haply-2diy.so,/dev/null",
                 {"not a serial port"});
}

}  // namespace test_cli_force

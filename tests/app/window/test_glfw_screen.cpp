// A real window, on an X server of the test's own: what is drawn
// in its context is what is drawn off screen, byte for byte.
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "app/window/glfw_screen.h"
#include "render/renderer.h"
#include "tests/render/sample_snapshot.h"

namespace limberg {
namespace test_glfw_screen {

/// Xvfb on a free display, ended with this object; `display` is empty where there is none.
struct XServer {
  pid_t pid = 0;
  std::string display;

  XServer() {
    int ends[2];
    if (pipe(ends) != 0) return;
    const std::string fd = std::to_string(ends[1]);
    const char* argv[] = {"Xvfb", "-displayfd", fd.c_str(), "-screen", "0", "640x480x24", "-nolisten", "tcp", nullptr};
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addclose(&actions, ends[0]);
    posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", 1, 0);
    posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", 1, 0);
    const bool begun = posix_spawnp(&pid, "Xvfb", &actions, nullptr, const_cast<char**>(argv), environ) == 0;
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    std::string number;
    for (char c; begun && read(ends[0], &c, 1) == 1 && c != '\n';) number += c;  // ends when it gives up as well
    close(ends[0]);
    if (!begun) pid = 0;
    if (!number.empty()) display = ":" + number;
  }
  ~XServer() {
    if (pid <= 0) return;
    kill(pid, SIGTERM);
    waitpid(pid, nullptr, 0);
  }
};

constexpr int kWidth = 320, kHeight = 240;

std::vector<Image> pictures(Renderer& renderer) {
  const Snapshot s = testing::sample_snapshot();
  const Camera camera =
      look_at_ball(Vec3f::Zero(), 18, Vec3f(0.05f, -0.6f, 0.8f), Vec3f::UnitZ(), 25, double(kWidth) / kHeight);
  DrawOptions o;
  o.width = kWidth, o.height = kHeight;
  std::vector<Image> out;
  for (const bool fine : {false, true}) {
    o.shadow = o.fine_skin = o.occlusion = fine;
    SceneBuilder builder;
    out.push_back(renderer.draw(builder.build(s), camera.view(double(kWidth) / kHeight), o));
  }
  return out;
}

// In a process of its own: a window's libraries and those of off-screen pictures each bring a driver along.
// 0: the pictures are in the files; 1: there is no window here; 2: another driver draws.
int draw_in_a_window(const std::string& file) {
  const XServer server;
  if (server.display.empty()) return 1;
  setenv("DISPLAY", server.display.c_str(), 1);
  unsetenv("WAYLAND_DISPLAY");
  try {
    const std::unique_ptr<DesktopScreen> screen = open_glfw_screen("test", kWidth, kHeight);
    Renderer renderer(screen->context());
    if (renderer.describe().find("llvmpipe") == std::string::npos) return 2;
    const std::vector<Image> drawn = pictures(renderer);
    renderer.present(kWidth, kHeight);
    for (size_t i = 0; i < drawn.size(); ++i) write_png(file + std::to_string(i) + ".png", drawn[i]);
  } catch (const RenderUnavailable&) {
    return 1;
  }
  return 0;
}

TEST(GlfwScreen, AWindowShowsTheBytesOfAnOffScreenPicture) {
  const std::string file =
      (std::filesystem::temp_directory_path() / ("limberg-window-" + std::to_string(getpid()) + "-")).string();
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    alarm(60);
    _exit(draw_in_a_window(file));
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
  if (WEXITSTATUS(status) == 1) GTEST_SKIP() << "no X server and no Xvfb with OpenGL here";
  if (WEXITSTATUS(status) == 2) GTEST_SKIP() << "another driver than the off-screen one's";
  ASSERT_EQ(WEXITSTATUS(status), 0);
  std::unique_ptr<Renderer> renderer;
  try {
    renderer = std::make_unique<Renderer>(make_offscreen_context());
  } catch (const RenderUnavailable& e) {
    GTEST_SKIP() << e.what();
  }
  const std::vector<Image> here = pictures(*renderer);
  for (size_t i = 0; i < here.size(); ++i) {
    const std::string name = file + std::to_string(i) + ".png";
    EXPECT_EQ(read_png(name), here[i]) << renderer->describe();
    std::filesystem::remove(name);
  }
}

}  // namespace test_glfw_screen
}  // namespace limberg

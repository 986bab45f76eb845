// A real window, on an X server of the test's own: what is drawn
// in its context is what is drawn off screen, byte for byte.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "app/window/glfw_screen.h"
#include "render/renderer.h"
#include "tests/app/headset/x_server.h"
#include "tests/render/sample_snapshot.h"

namespace limberg {
namespace test_glfw_screen {

using testing::XServer;

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

// The part limberg-glfw.so: a window of the desktop by GLFW.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>

#include "app/window/desk.h"
#include "app/window/glfw_screen.h"

namespace limberg {

namespace {

std::string last_error() {
  const char* why = nullptr;
  glfwGetError(&why);
  return why ? why : "no reason given";
}

uint32_t mods_of(int glfw) {
  return (glfw & GLFW_MOD_SHIFT ? WindowEvent::shift : 0u) | (glfw & GLFW_MOD_CONTROL ? WindowEvent::control : 0u) |
         (glfw & GLFW_MOD_ALT ? WindowEvent::alt : 0u);
}

// Of the keys that are used; 0 for the others.
int32_t key_of(int glfw) {
  if ((glfw >= GLFW_KEY_A && glfw <= GLFW_KEY_Z) || (glfw >= GLFW_KEY_0 && glfw <= GLFW_KEY_9)) return glfw;
  switch (glfw) {
    case GLFW_KEY_SPACE:
      return WindowEvent::space;
    case GLFW_KEY_ESCAPE:
      return WindowEvent::escape;
    case GLFW_KEY_ENTER:
      return WindowEvent::enter;
    case GLFW_KEY_TAB:
      return WindowEvent::tab;
    case GLFW_KEY_BACKSPACE:
      return WindowEvent::backspace;
    case GLFW_KEY_DELETE:
      return WindowEvent::remove;
    case GLFW_KEY_LEFT:
      return WindowEvent::arrow_left;
    case GLFW_KEY_RIGHT:
      return WindowEvent::arrow_right;
    case GLFW_KEY_UP:
      return WindowEvent::arrow_up;
    case GLFW_KEY_DOWN:
      return WindowEvent::arrow_down;
    case GLFW_KEY_HOME:
      return WindowEvent::home;
    case GLFW_KEY_END:
      return WindowEvent::end;
    case GLFW_KEY_F10:
      return WindowEvent::f10;
    case GLFW_KEY_PAGE_UP:
      return WindowEvent::page_up;
    case GLFW_KEY_PAGE_DOWN:
      return WindowEvent::page_down;
    case GLFW_KEY_MINUS:
    case GLFW_KEY_KP_SUBTRACT:
      return '-';
    case GLFW_KEY_EQUAL:
    case GLFW_KEY_KP_ADD:
      return '=';
    case GLFW_KEY_LEFT_BRACKET:
    case GLFW_KEY_RIGHT_BRACKET:
      return glfw;
    case GLFW_KEY_F1:
      return WindowEvent::f1;
    default:
      return 0;
  }
}

class WindowContext final : public GlContext {
 public:
  explicit WindowContext(GLFWwindow* w) : window_(w) {}
  ~WindowContext() override { glfwMakeContextCurrent(nullptr); }
  void make_current() override {
    if (glfwGetCurrentContext() == window_) return;
    glfwMakeContextCurrent(window_);
    if (glfwGetCurrentContext() != window_)
      throw RenderUnavailable("no window: its context could not be made current: " + last_error());
    glfwSwapInterval(0);  // frames are paced by the session
  }
  void* address(const char* function) const override { return reinterpret_cast<void*>(glfwGetProcAddress(function)); }
  std::string describe() const override { return "window"; }
  void show() override { glfwSwapBuffers(window_); }

 private:
  GLFWwindow* window_;
};

// Until the first picture is ready the window has the colour of its panels: black looks like a defect.
void paint_plain(GLFWwindow* w) {
  glfwMakeContextCurrent(w);
  const auto colour = reinterpret_cast<void (*)(float, float, float, float)>(glfwGetProcAddress("glClearColor"));
  const auto clear = reinterpret_cast<void (*)(unsigned)>(glfwGetProcAddress("glClear"));
  if (colour && clear) {
    constexpr unsigned kColourBuffer = 0x4000;  // GL_COLOR_BUFFER_BIT
    colour(kPaper[0], kPaper[1], kPaper[2], kPaper[3]);
    clear(kColourBuffer);
    glfwSwapBuffers(w);
  }
  glfwMakeContextCurrent(nullptr);
}

class GlfwScreen final : public DesktopScreen {
 public:
  GlfwScreen(const std::string& title, int width, int height);
  ~GlfwScreen() override;
  std::unique_ptr<GlContext> context() override { return std::make_unique<WindowContext>(window_); }
  void pump() override { glfwPollEvents(); }

 private:
  static GlfwScreen& of(GLFWwindow* w) { return *static_cast<GlfwScreen*>(glfwGetWindowUserPointer(w)); }
  void send(const WindowEvent& e) {
    if (on_event)
      on_event(e);
    else
      events.push(e);
  }
  void measure() {
    int w = 0, h = 0, fw = 0, fh = 0;
    glfwGetWindowSize(window_, &w, &h);
    glfwGetFramebufferSize(window_, &fw, &fh);
    if (fw < 1 || fh < 1) return;  // an icon
    width = std::max(fw, 64), height = std::max(fh, 64);
    scale_x_ = float(fw) / float(std::max(w, 1)), scale_y_ = float(fh) / float(std::max(h, 1));
  }

  GLFWwindow* window_ = nullptr;
  float scale_x_ = 1, scale_y_ = 1;  // pixels of the frame for one unit of the desktop
};

GlfwScreen::GlfwScreen(const std::string& title, int w, int h) {
  if (!glfwInit()) throw RenderUnavailable("no window: " + last_error());
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  window_ = glfwCreateWindow(w, h, title.c_str(), nullptr, nullptr);
  if (!window_) {
    const std::string why = last_error();
    glfwTerminate();
    throw RenderUnavailable("no window: " + why);
  }
  GLFWwindow* const g = window_;
  paint_plain(g);
  glfwSetWindowUserPointer(g, this);
  measure();
  glfwSetFramebufferSizeCallback(g, [](GLFWwindow* x, int, int) { of(x).measure(); });
  glfwSetWindowCloseCallback(g, [](GLFWwindow* x) {
    of(x).open = false;
    glfwHideWindow(x);  // the session may have something left to do
  });
  glfwSetCursorPosCallback(g, [](GLFWwindow* x, double px, double py) {
    GlfwScreen& s = of(x);
    WindowEvent e;
    e.kind = WindowEvent::pointer, e.x = float(px) * s.scale_x_, e.y = float(py) * s.scale_y_;
    s.send(e);
  });
  glfwSetMouseButtonCallback(g, [](GLFWwindow* x, int button, int action, int mods) {
    WindowEvent e;
    e.kind = WindowEvent::button, e.code = button, e.down = action == GLFW_PRESS, e.mods = mods_of(mods);
    if (button < 3) of(x).send(e);
  });
  glfwSetScrollCallback(g, [](GLFWwindow* x, double dx, double dy) {
    WindowEvent e;
    e.kind = WindowEvent::wheel, e.x = float(dx), e.y = float(dy);
    of(x).send(e);
  });
  glfwSetKeyCallback(g, [](GLFWwindow* x, int key, int, int action, int mods) {
    WindowEvent e;
    e.kind = WindowEvent::key, e.code = key_of(key), e.down = action != GLFW_RELEASE, e.mods = mods_of(mods);
    if (e.code) of(x).send(e);
  });
  glfwSetCharCallback(g, [](GLFWwindow* x, unsigned c) {
    WindowEvent e;
    e.kind = WindowEvent::text, e.code = int32_t(c), e.down = 1;
    of(x).send(e);
  });
}

GlfwScreen::~GlfwScreen() {
  glfwDestroyWindow(window_);
  glfwTerminate();
}

}  // namespace
}  // namespace limberg

extern "C" limberg::DesktopScreen* limberg_glfw_screen(const std::string& title, int width, int height) {
  return new limberg::GlfwScreen(title, width, height);
}

#include <dlfcn.h>

#include <array>

#include "render/gl_context.h"

namespace limberg {

namespace {

// The part of Xlib and GLX (1.3, GLX_ARB_create_context) that is used, declared here so that no header and no library
// is needed to build.
using XHandle = void*;
using XOpenFn = XHandle (*)(const char*);
using XCloseFn = int (*)(XHandle);
using XErrorFn = int (*)(XHandle, void*);
using XSetErrorFn = XErrorFn (*)(XErrorFn);
using XSyncFn = int (*)(XHandle, int);
using XFreeFn = int (*)(void*);
using ChooseConfigFn = XHandle* (*)(XHandle display, int screen, const int* attributes, int* n);
using VisualFn = void* (*)(XHandle display, XHandle config);
using PbufferFn = unsigned long (*)(XHandle display, XHandle config, const int* attributes);
using DestroyPbufferFn = void (*)(XHandle display, unsigned long pbuffer);
using GlxCreateFn = XHandle (*)(XHandle display, XHandle config, XHandle share, int direct, const int* attributes);
using GlxDestroyFn = void (*)(XHandle display, XHandle context);
using GlxCurrentFn = int (*)(XHandle display, unsigned long draw, unsigned long read, XHandle context);
using GlxAddressFn = void (*(*)(const unsigned char*))();

constexpr int kDrawableType = 0x8010, kPbufferBit = 4, kRenderType = 0x8011, kRgbaBit = 1, kXRenderable = 0x8012;
constexpr int kPbufferWidth = 0x8041, kPbufferHeight = 0x8040;
constexpr int kGlxMajor = 0x2091, kGlxMinor = 0x2092, kGlxProfile = 0x9126, kGlxCore = 1;

/// The head of Xlib's XVisualInfo.
struct VisualInfo {
  void* visual;
  unsigned long id;
};

void* open_library(const std::string& file, const char* package) {
  if (void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) return library;  // never closed, as with OSMesa
  const char* why = dlerror();
  throw RenderUnavailable("no pictures: " + file + " cannot be loaded (" + (why ? why : "unknown") + "); install " +
                          package);
}

template <class F>
F glx_symbol(void* library, const char* name, const std::string& file) {
  void* p = dlsym(library, name);
  if (!p) throw RenderUnavailable("no pictures: " + file + " lacks " + name + "; expected GLX 1.3 (Debian: libgl1)");
  return reinterpret_cast<F>(p);
}

class GlxContext final : public GlContext {
 public:
  explicit GlxContext(const std::string& file) {
    const std::string x11 = "libX11.so.6";
    void* const x = open_library(x11, "libx11-6");
    void* const gl = open_library(file, "libgl1");
    close_ = glx_symbol<XCloseFn>(x, "XCloseDisplay", x11);
    current_ = glx_symbol<GlxCurrentFn>(gl, "glXMakeContextCurrent", file);
    destroy_ = glx_symbol<GlxDestroyFn>(gl, "glXDestroyContext", file);
    destroy_pbuffer_ = glx_symbol<DestroyPbufferFn>(gl, "glXDestroyPbuffer", file);
    address_ = glx_symbol<GlxAddressFn>(gl, "glXGetProcAddressARB", file);
    display_ = glx_symbol<XOpenFn>(x, "XOpenDisplay", x11)(nullptr);
    if (!display_) throw RenderUnavailable("no pictures: no X server answers; expected DISPLAY to name one");
    try {
      make(x, x11, gl, file);
    } catch (const RenderUnavailable&) {
      let_go();
      throw;
    }
  }
  ~GlxContext() override { let_go(); }
  void make_current() override {
    if (!current_(display_, pbuffer_, pbuffer_, context_))
      throw RenderUnavailable("no pictures: GLX could not make its context current");
  }
  void* address(const char* function) const override {
    return reinterpret_cast<void*>(address_(reinterpret_cast<const unsigned char*>(function)));
  }
  std::string describe() const override { return "GLX without a window"; }
  NativeContext native() const override {
    NativeContext n;
    n.kind = NativeContext::glx, n.display = display_, n.config = config_, n.context = context_;
    n.drawable = pbuffer_, n.visual = visual_;
    return n;
  }

 private:
  void make(void* x, const std::string& x11, void* gl, const std::string& file) {
    const auto set_error = glx_symbol<XSetErrorFn>(x, "XSetErrorHandler", x11);
    const auto sync = glx_symbol<XSyncFn>(x, "XSync", x11);
    const auto free = glx_symbol<XFreeFn>(x, "XFree", x11);
    const auto create = reinterpret_cast<GlxCreateFn>(address("glXCreateContextAttribsARB"));
    const std::array<int, 7> wanted{kDrawableType, kPbufferBit, kRenderType, kRgbaBit, kXRenderable, 1, 0};
    int n = 0;
    XHandle* configs = glx_symbol<ChooseConfigFn>(gl, "glXChooseFBConfig", file)(display_, 0, wanted.data(), &n);
    if (!configs || n < 1 || !create)
      throw RenderUnavailable("no pictures: the X server has no GLX 1.3 with off-screen buffers");
    config_ = configs[0];
    free(configs);
    if (void* info = glx_symbol<VisualFn>(gl, "glXGetVisualFromFBConfig", file)(display_, config_)) {
      visual_ = unsigned(static_cast<VisualInfo*>(info)->id);
      free(info);
    }
    // Xlib's own handler of a refusal ends the program.
    const XErrorFn before = set_error([](XHandle, void*) { return 0; });
    const std::array<int, 5> size{kPbufferWidth, 16, kPbufferHeight, 16, 0};
    pbuffer_ = glx_symbol<PbufferFn>(gl, "glXCreatePbuffer", file)(display_, config_, size.data());
    const std::array<int, 7> version{kGlxMajor, 3, kGlxMinor, 3, kGlxProfile, kGlxCore, 0};
    context_ = create(display_, config_, nullptr, 1, version.data());
    sync(display_, 0);
    set_error(before);
    if (!pbuffer_ || !context_) throw RenderUnavailable("no pictures: GLX refused a core context of OpenGL 3.3");
  }

  void let_go() {
    if (context_) current_(display_, 0, 0, nullptr), destroy_(display_, context_);
    if (pbuffer_) destroy_pbuffer_(display_, pbuffer_);
    close_(display_);
  }

  XHandle display_ = nullptr, config_ = nullptr, context_ = nullptr;
  unsigned long pbuffer_ = 0;
  unsigned visual_ = 0;
  XCloseFn close_ = nullptr;
  GlxCurrentFn current_ = nullptr;
  GlxDestroyFn destroy_ = nullptr;
  DestroyPbufferFn destroy_pbuffer_ = nullptr;
  GlxAddressFn address_ = nullptr;
};

}  // namespace

std::unique_ptr<GlContext> make_glx_context(const std::string& library) {
  return std::make_unique<GlxContext>(library);
}

}  // namespace limberg

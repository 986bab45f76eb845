#include <cstdlib>

#include "render/gl_context.h"

#ifdef LIMBERG_EGL
#include <dlfcn.h>

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace limberg {

namespace {

// The part of EGL that is used (EGL 1.5), declared here so that no header and no library is needed to build.
using Handle = void*;
using PlatformDisplayFn = Handle (*)(unsigned platform, void* native, const intptr_t* attributes);
using InitializeFn = unsigned (*)(Handle display, int* major, int* minor);
using BindApiFn = unsigned (*)(unsigned api);
using CreateContextFn = Handle (*)(Handle display, Handle config, Handle share, const int* attributes);
using DestroyContextFn = unsigned (*)(Handle display, Handle context);
using EglMakeCurrentFn = unsigned (*)(Handle display, Handle draw, Handle read, Handle context);
using EglAddressFn = void (*(*)(const char*))();
using QueryDevicesFn = unsigned (*)(int room, Handle* devices, int* n);  // EGL_EXT_device_enumeration
using DeviceStringFn = const char* (*)(Handle device, int name);         // EGL_EXT_device_query

constexpr unsigned kSurfacelessMesa = 0x31DD, kDevicePlatform = 0x313F, kOpenGlApi = 0x30A2;
constexpr int kExtensions = 0x3055;
constexpr int kEglMajor = 0x3098, kEglMinor = 0x30FB, kProfileMask = 0x30FD, kEglCoreProfile = 1, kNone = 0x3038;

template <class F>
F egl_symbol(void* library, const char* name, const std::string& file) {
  void* p = dlsym(library, name);
  if (!p) throw RenderUnavailable("no pictures: " + file + " lacks " + name + "; expected EGL 1.5 (Debian: libegl1)");
  return reinterpret_cast<F>(p);
}

class EglContext final : public GlContext {
 public:
  explicit EglContext(const std::string& file) {
    void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);  // never closed, as with OSMesa
    if (!library) {
      const char* why = dlerror();
      throw RenderUnavailable("no pictures: " + file + " cannot be loaded (" + (why ? why : "unknown") +
                              "); install libegl1");
    }
    const auto display = egl_symbol<PlatformDisplayFn>(library, "eglGetPlatformDisplay", file);
    const auto initialize = egl_symbol<InitializeFn>(library, "eglInitialize", file);
    bind_api_ = egl_symbol<BindApiFn>(library, "eglBindAPI", file);
    const auto create = egl_symbol<CreateContextFn>(library, "eglCreateContext", file);
    destroy_ = egl_symbol<DestroyContextFn>(library, "eglDestroyContext", file);
    make_current_ = egl_symbol<EglMakeCurrentFn>(library, "eglMakeCurrent", file);
    address_ = egl_symbol<EglAddressFn>(library, "eglGetProcAddress", file);
    // Cards first, each by itself (drivers of makers have no other way without a screen), then Mesa without a surface,
    // which draws by a card that it knows or in software.
    bool any = false;
    const auto try_display = [&](Handle candidate) {
      if (!candidate || !initialize(candidate, nullptr, nullptr)) return;
      any = true;
      bind_api_(kOpenGlApi);
      const std::array<int, 7> attributes{kEglMajor, 3, kEglMinor, 3, kProfileMask, kEglCoreProfile, kNone};
      // No config: nothing but framebuffer objects is drawn to.
      if (Handle made = create(candidate, nullptr, nullptr, attributes.data())) display_ = candidate, context_ = made;
    };
    for (Handle card : cards()) {
      if (!context_) try_display(display(kDevicePlatform, card, nullptr));
    }
    if (!context_) try_display(display(kSurfacelessMesa, nullptr, nullptr));
    if (!context_ && any) throw RenderUnavailable("no pictures: EGL refused a core context of OpenGL 3.3");
    if (!context_)
      throw RenderUnavailable(
          "no pictures: EGL has neither a graphics card nor a display without a surface; expected " +
          std::string("the card's driver, or Mesa's (Debian: libegl-mesa0)"));
  }
  ~EglContext() override {
    if (!context_) return;
    make_current_(display_, nullptr, nullptr, nullptr);
    destroy_(display_, context_);
  }
  void make_current() override {
    bind_api_(kOpenGlApi);  // of this thread
    if (!make_current_(display_, nullptr, nullptr, context_))
      throw RenderUnavailable("no pictures: EGL could not make its context current without a surface");
  }
  void* address(const char* function) const override { return reinterpret_cast<void*>(address_(function)); }
  std::string describe() const override { return "EGL without a surface"; }
  NativeContext native() const override {
    NativeContext n;
    n.kind = NativeContext::egl, n.display = display_, n.context = context_, n.address = address_;
    return n;
  }

 private:
  /// The devices that are not software; none where EGL cannot list them.
  std::vector<Handle> cards() const {
    const auto query = reinterpret_cast<QueryDevicesFn>(address_("eglQueryDevicesEXT"));
    const auto text = reinterpret_cast<DeviceStringFn>(address_("eglQueryDeviceStringEXT"));
    std::array<Handle, 16> all{};
    int n = 0;
    std::vector<Handle> found;
    if (!query || !text || !query(int(all.size()), all.data(), &n)) return found;
    for (int k = 0; k < n && k < int(all.size()); ++k) {
      const char* can = text(all[size_t(k)], kExtensions);
      if (!can || std::string_view(can).find("EGL_MESA_device_software") == std::string_view::npos)
        found.push_back(all[size_t(k)]);
    }
    return found;
  }

  Handle display_ = nullptr, context_ = nullptr;
  BindApiFn bind_api_ = nullptr;
  DestroyContextFn destroy_ = nullptr;
  EglMakeCurrentFn make_current_ = nullptr;
  EglAddressFn address_ = nullptr;
};

}  // namespace

std::unique_ptr<GlContext> make_egl_context(const std::string& library) {
  return std::make_unique<EglContext>(library);
}

}  // namespace limberg

#else

namespace limberg {

std::unique_ptr<GlContext> make_egl_context(const std::string&) {
  throw RenderUnavailable("no pictures: this program was built without EGL (LIMBERG_EGL=OFF)");
}

}  // namespace limberg
#endif

namespace limberg {

void software_drawing_threads(int n) { setenv("LP_NUM_THREADS", std::to_string(n).c_str(), 0); }

std::unique_ptr<GlContext> make_offscreen_context(int software_threads) {
  const char* chosen = std::getenv("LIMBERG_GL");
  const std::string kind = chosen ? chosen : "";
  if (kind == "egl") return make_egl_context();
  if (kind == "osmesa") return make_osmesa_context({.threads = software_threads});
  if (!kind.empty()) throw RenderUnavailable("no pictures: LIMBERG_GL=" + kind + " is unknown; expected osmesa or egl");
  try {
    return make_osmesa_context({.threads = software_threads});
  } catch (const RenderUnavailable& first) {
    try {
      return make_egl_context();
    } catch (const RenderUnavailable& second) {
      throw RenderUnavailable(std::string(first.what()) + "; " + second.what());
    }
  }
}

}  // namespace limberg

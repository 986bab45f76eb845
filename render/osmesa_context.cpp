#include <cstdlib>

#include "render/gl_context.h"

#ifdef LIMBERG_OSMESA
#include <dlfcn.h>

#include <array>

#ifdef __SANITIZE_ADDRESS__
// The library keeps a few hundred bytes of its own until the process ends.
extern "C" const char* __lsan_default_suppressions() { return "leak:libOSMesa\n"; }
#endif

namespace limberg {

namespace {

// The part of the OSMesa interface that is used (GL/osmesa.h), declared here so that no GL header with linked
// prototypes is needed.
using OsContext = void*;
using CreateFn = OsContext (*)(const int* attributes, OsContext share);
using DestroyFn = void (*)(OsContext);
using MakeCurrentFn = unsigned char (*)(OsContext, void* buffer, unsigned type, int width, int height);
using AddressFn = void (*(*)(const char*))();

constexpr int kFormat = 0x22, kRgba = 0x1908, kDepthBits = 0x30, kStencilBits = 0x31, kAccumBits = 0x32,
              kProfile = 0x33, kCoreProfile = 0x34, kMajor = 0x36, kMinor = 0x37;
constexpr unsigned kUnsignedByte = 0x1401;

template <class F>
F symbol(void* library, const char* name, const std::string& file) {
  void* p = dlsym(library, name);
  if (!p) throw RenderUnavailable(file + " lacks " + name + "; expected OSMesa 11.2 or newer (Debian: libosmesa6)");
  return reinterpret_cast<F>(p);
}

class OsMesaContext final : public GlContext {
 public:
  explicit OsMesaContext(const OsMesaSettings& s) {
    if (s.threads >= 0) setenv("LP_NUM_THREADS", std::to_string(s.threads).c_str(), 1);
    // Never closed: the driver's own threads and exit handlers live in the library.
    void* library = dlopen(s.library.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library) {
      const char* why = dlerror();
      throw RenderUnavailable("no pictures: " + s.library + " cannot be loaded (" + (why ? why : "unknown") +
                              "); install libosmesa6");
    }
    const auto create = symbol<CreateFn>(library, "OSMesaCreateContextAttribs", s.library);
    destroy_ = symbol<DestroyFn>(library, "OSMesaDestroyContext", s.library);
    make_current_ = symbol<MakeCurrentFn>(library, "OSMesaMakeCurrent", s.library);
    address_ = symbol<AddressFn>(library, "OSMesaGetProcAddress", s.library);
    const std::array<int, 16> attributes{kFormat, kRgba,    kDepthBits,   24,     kStencilBits, 0,      kAccumBits,
                                         0,       kProfile, kCoreProfile, kMajor, s.major,      kMinor, s.minor,
                                         0,       0};
    context_ = create(attributes.data(), nullptr);
    if (!context_)
      throw RenderUnavailable("no pictures: OSMesa refused a core context of OpenGL " + std::to_string(s.major) + "." +
                              std::to_string(s.minor) + "; expected 3.3 (Debian: libosmesa6)");
    name_ = "OSMesa (" + s.library + ")";
  }
  ~OsMesaContext() override {
    if (context_) destroy_(context_);
  }
  void make_current() override {
    // OSMesa wants a colour buffer of its own; everything is drawn into a framebuffer object instead.
    if (!make_current_(context_, buffer_.data(), kUnsignedByte, 4, 4))
      throw RenderUnavailable("no pictures: OSMesa could not make its context current");
  }
  void* address(const char* function) const override { return reinterpret_cast<void*>(address_(function)); }
  std::string describe() const override { return name_; }

 private:
  OsContext context_ = nullptr;
  DestroyFn destroy_ = nullptr;
  MakeCurrentFn make_current_ = nullptr;
  AddressFn address_ = nullptr;
  std::array<unsigned char, 4 * 4 * 4> buffer_{};
  std::string name_;
};

}  // namespace

std::unique_ptr<GlContext> make_osmesa_context(const OsMesaSettings& settings) {
  return std::make_unique<OsMesaContext>(settings);
}

}  // namespace limberg

#else

namespace limberg {

std::unique_ptr<GlContext> make_osmesa_context(const OsMesaSettings&) {
  throw RenderUnavailable("no pictures: this program was built without OSMesa (LIMBERG_OSMESA=OFF)");
}

}  // namespace limberg
#endif

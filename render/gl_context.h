#pragma once
// An OpenGL 3.3 core context, wherever it comes from. The renderer draws into its own framebuffer object and fetches
// its functions through `address`, so every kind of context gives the same picture.
//
// A context belongs to the thread that made it current. Software drivers start worker threads when a context is made,
// and these inherit priority and affinity from the calling thread: set both before.
#include <memory>
#include <stdexcept>
#include <string>

namespace limberg {

/// Pictures cannot be made here: the reason and what to do, in one line. Everything but pictures still works.
class RenderUnavailable : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A context as those have to be told of it who share its objects: the runtime of a headset.
struct NativeContext {
  enum Kind { none, egl, glx } kind = none;
  void *display = nullptr, *config = nullptr,
       *context = nullptr;                      // EGL's, or GLX's (Display*, GLXFBConfig, GLXContext)
  unsigned long drawable = 0;                   // GLX: what it draws to
  unsigned visual = 0;                          // GLX: number of the visual
  void (*(*address)(const char*))() = nullptr;  // EGL: where its functions are
};

class GlContext {
 public:
  virtual ~GlContext() = default;
  virtual void make_current() = 0;                        // RenderUnavailable when refused
  virtual void* address(const char* function) const = 0;  // null when unknown
  virtual std::string describe() const = 0;
  /// Shows what was drawn into the context's own frame; nothing where there is no window.
  virtual void show() {}
  virtual NativeContext native() const { return {}; }
};

struct OsMesaSettings {
  std::string library = "libOSMesa.so.8";
  int major = 3, minor = 3;
  /// Rasteriser threads: 0 = the calling thread draws, n = workers. -1 leaves the choice to Mesa or to LP_NUM_THREADS.
  /// Mesa reads it from the environment when the first context of the process is made; later values have no effect.
  int threads = -1;
};

/// Off-screen context through OSMesa, loaded with dlopen (never linked: libGL would take its symbols).
/// RenderUnavailable when the build has LIMBERG_OSMESA off, the library is absent or it refuses the version.
std::unique_ptr<GlContext> make_osmesa_context(const OsMesaSettings& settings = {});

/// Off-screen context through EGL without a surface, loaded with dlopen: the graphics card's driver where there is one.
/// RenderUnavailable when the library is absent or refuses OpenGL 3.3 core.
std::unique_ptr<GlContext> make_egl_context(const std::string& library = "libEGL.so.1");

/// Off-screen context of an X server, of a connection of its own, with both libraries loaded by dlopen.
/// RenderUnavailable when there is no server, no library or no OpenGL 3.3 core.
std::unique_ptr<GlContext> make_glx_context(const std::string& library = "libGL.so.1");

/// How many threads of their own software drivers may use: 0 = the thread that draws does
/// all of it, so that its priority and its share of time (app/session/drawing_share.h)
/// are the picture's. Before the first context of the process; a user's own
/// LP_NUM_THREADS in the environment stands. Graphics cards do not care.
void software_drawing_threads(int n);

/// The off-screen context of this machine: OSMesa, or EGL where there is none. LIMBERG_GL=osmesa|egl chooses.
std::unique_ptr<GlContext> make_offscreen_context(int software_threads = -1);

}  // namespace limberg

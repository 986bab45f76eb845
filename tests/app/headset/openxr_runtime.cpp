// A runtime of OpenXR for tests, found by the loader through XR_RUNTIME_JSON: swapchains are textures, poses come from
// a script, and what was handed in is kept as pictures and as lines of a log.
//
//   LIMBERG_TEST_XR=FILE      the script, one thing a line (below); none: one headset that stands still
//   LIMBERG_TEST_XR_OUT=DIR   log.txt and frame-N-EYE.ppm are left there
//
//   views WIDTH HEIGHT            of an eye, pixels (96 80)
//   period_ms MS                  of a frame (11); "fast": nobody waits for it
//   no EXTENSION | no headset     that the runtime does not have
//   head T  x y z  w x y z        keys of a path: seconds since the session's first frame, metres, quaternion
//   left T  x y z  w x y z  press clutch place        a controller; "left T off": not tracked from there on
//   left_hand T  x y z  w x y z  aperture_m           a tracked hand: its forefinger's tip; the thumb's lies along -x
//   keep N ...                    pictures of these frames are kept (from 0); "keep last": of the newest one
//   at N lose | lose_instance | stop | exit           what happens after frame N
//   end_s T [N]                   the program gets a Ctrl-C then, in its N-th session (1)
//   fail FUNCTION                 xr... answers XR_ERROR_RUNTIME_FAILURE
//
// It is stricter than a runtime need be: the session's context has to be current where images are made and handed in,
// images are released before a frame ends, poses that come back are those that were given out.
#define XR_USE_PLATFORM_EGL
#define XR_USE_PLATFORM_XLIB
#define XR_USE_GRAPHICS_API_OPENGL
#define XR_USE_TIMESPEC
#include <EGL/egl.h>
#include <GL/glcorearb.h>
#include <GL/glx.h>
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <fstream>
#include <map>
#include <mutex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

// What loader and runtime say to each other first; the loader's
// documentation has the layout, Debian's package no header of it.
struct XrNegotiateLoaderInfo {
  int structType;
  uint32_t structVersion;
  size_t structSize;
  uint32_t minInterfaceVersion, maxInterfaceVersion;
  XrVersion minApiVersion, maxApiVersion;
};
struct XrNegotiateRuntimeRequest {
  int structType;
  uint32_t structVersion;
  size_t structSize;
  uint32_t runtimeInterfaceVersion;
  XrVersion runtimeApiVersion;
  PFN_xrGetInstanceProcAddr getInstanceProcAddr;
};

namespace {

constexpr uint32_t kInterface = 1;
constexpr XrSystemId kSystem = 7;
constexpr int64_t kNsPerS = 1'000'000'000;

int64_t now_ns() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return int64_t(t.tv_sec) * kNsPerS + t.tv_nsec;
}

// ---- The script

struct Key {
  double t = 0;
  XrPosef pose{{0, 0, 0, 1}, {0, 0, 0}};
  float extra[3] = {0, 0, 0};
  bool on = true;
};

using Path = std::vector<Key>;

/// Linear between the keys; what is on or off is so from its key on.
Key at(const Path& path, double t) {
  if (path.empty()) return {.on = false};
  size_t next = 0;
  while (next < path.size() && path[next].t <= t) ++next;
  if (next == 0) return path.front();
  Key k = path[next - 1];
  if (next == path.size() || !k.on || !path[next].on) return k;
  const Key& b = path[next];
  const float s = float((t - k.t) / (b.t - k.t));
  const auto mix = [s](float& x, float y) { x += s * (y - x); };
  mix(k.pose.position.x, b.pose.position.x), mix(k.pose.position.y, b.pose.position.y);
  mix(k.pose.position.z, b.pose.position.z);
  XrQuaternionf &q = k.pose.orientation, r = b.pose.orientation;
  if (q.x * r.x + q.y * r.y + q.z * r.z + q.w * r.w < 0) r = {-r.x, -r.y, -r.z, -r.w};
  mix(q.x, r.x), mix(q.y, r.y), mix(q.z, r.z), mix(q.w, r.w);
  const float n = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  q = {q.x / n, q.y / n, q.z / n, q.w / n};
  mix(k.extra[0], b.extra[0]);  // the aperture; buttons are of the earlier key
  return k;
}

struct Script {
  uint32_t width = 96, height = 80;
  double period_ms = 11;
  bool fast = false, keep_last = false;
  double end_s = -1;
  int end_session = 1;
  std::set<std::string> without, failing;
  std::map<std::string, Path> path;
  std::set<int64_t> keep;
  std::map<int64_t, std::vector<std::string>> at_frame;
};

Script read_script() {
  Script s;
  const char* file = std::getenv("LIMBERG_TEST_XR");
  std::ifstream in(file ? file : "");
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string what;
    if (!(words >> what) || what[0] == '#') continue;
    if (what == "views") {
      words >> s.width >> s.height;
    } else if (what == "period_ms") {
      words >> s.period_ms;
    } else if (what == "end_s") {
      int session = 1;
      words >> s.end_s;
      if (words >> session) s.end_session = session;
    } else if (what == "fast") {
      s.fast = true;
    } else if (what == "no") {
      for (std::string e; words >> e;) s.without.insert(e);
    } else if (what == "fail") {
      for (std::string e; words >> e;) s.failing.insert(e);
    } else if (what == "keep") {
      for (std::string e; words >> e;)
        if (e == "last")
          s.keep_last = true;
        else
          s.keep.insert(std::stoll(e));
    } else if (what == "at") {
      int64_t n = 0;
      std::string e;
      words >> n >> e;
      s.at_frame[n].push_back(e);
    } else {
      Key k;
      std::string first;
      words >> k.t >> first;
      if (first == "off") {
        k.on = false;
      } else {
        k.pose.position.x = std::stof(first);
        words >> k.pose.position.y >> k.pose.position.z >> k.pose.orientation.w >> k.pose.orientation.x >>
            k.pose.orientation.y >> k.pose.orientation.z;
        for (float& e : k.extra) words >> e;
      }
      s.path[what].push_back(k);
    }
  }
  return s;
}

// ---- State

struct Gl {
  PFNGLGENTEXTURESPROC GenTextures = nullptr;
  PFNGLDELETETEXTURESPROC DeleteTextures = nullptr;
  PFNGLBINDTEXTUREPROC BindTexture = nullptr;
  PFNGLTEXIMAGE2DPROC TexImage2D = nullptr;
  PFNGLGETTEXIMAGEPROC GetTexImage = nullptr;
  PFNGLGETINTEGERVPROC GetIntegerv = nullptr;
  PFNGLPIXELSTOREIPROC PixelStorei = nullptr;
};

struct Swapchain {
  uint32_t width = 0, height = 0;
  std::array<GLuint, 3> texture{};
  uint32_t next = 0;
  std::deque<uint32_t> acquired;
  bool waited = false;
  int64_t released = -1;  // the newest image
};

struct Space {
  enum Kind { view, local, stage, of_hand } kind = local;
  XrPath hand = XR_NULL_PATH;
};

struct Action {
  std::string name;
  XrActionType type = XR_ACTION_TYPE_BOOLEAN_INPUT;
};

struct Runtime {
  std::mutex mutex;
  Script script;
  std::string out;
  bool have_session = false, running = false, focused = false, in_frame = false, exiting = false, ended = false;
  bool lost = false, instance_lost = false, attached = false;
  int64_t session_ns = 0, frame = 0, waited = 0, shown_ns = 0, last_shown_ns = 0;
  std::deque<XrEventDataBuffer> events;
  std::deque<std::string> paths;
  std::map<uint64_t, Swapchain> swapchains;
  std::map<uint64_t, Space> spaces;
  std::map<uint64_t, Action> actions;
  std::map<uint64_t, bool> trackers;                // left?
  std::map<int64_t, std::array<XrPosef, 2>> given;  // eyes, by the time they were asked for
  std::set<std::string> enabled;
  uint64_t next_handle = 100;
  int sessions = 0;
  Gl gl;
  bool egl = false;
  EGLContext egl_context = nullptr;
  GLXContext glx_context = nullptr;
};

Runtime& rt() {
  static Runtime r;
  return r;
}

std::lock_guard<std::mutex> lock() { return std::lock_guard(rt().mutex); }

void log(const std::string& line) {
  if (rt().out.empty()) return;
  std::ofstream(rt().out + "/log.txt", std::ios::app) << line << "\n";
}

bool fails(const char* function) { return rt().script.failing.contains(function); }

#define MAY_FAIL(name) \
  if (fails(name)) return XR_ERROR_RUNTIME_FAILURE
#define SESSION_LIVES()                                  \
  if (rt().instance_lost) return XR_ERROR_INSTANCE_LOST; \
  if (rt().lost) return XR_ERROR_SESSION_LOST

void state_changed(XrSessionState state) {
  XrEventDataBuffer b{};
  auto* e = reinterpret_cast<XrEventDataSessionStateChanged*>(&b);
  *e = {XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED, nullptr, reinterpret_cast<XrSession>(3), state, now_ns()};
  rt().events.push_back(b);
  rt().focused = state == XR_SESSION_STATE_FOCUSED;
}

template <class F>
PFN_xrVoidFunction plain(F* f) {
  return reinterpret_cast<PFN_xrVoidFunction>(f);
}

template <class T>
XrResult enumerate(const std::vector<T>& all, uint32_t room, uint32_t* count, T* to) {
  *count = uint32_t(all.size());
  if (room == 0) return XR_SUCCESS;
  if (room < all.size()) return XR_ERROR_SIZE_INSUFFICIENT;
  std::copy(all.begin(), all.end(), to);
  return XR_SUCCESS;
}

/// A machine may be slow to begin.
double since_session(XrTime t) {
  return rt().frame == 0 ? 0 : std::max(0.0, double(t - rt().session_ns) / double(kNsPerS));
}
Key head_at(XrTime t) {
  Key k = at(rt().script.path["head"], since_session(t));
  if (!k.on) k = {.pose = {{0, 0, 0, 1}, {0, 1.6f, 0}}};
  return k;
}

XrVector3f turned(const XrQuaternionf& q, const XrVector3f& v) {
  const XrVector3f u{q.x, q.y, q.z};
  const auto cross = [](const XrVector3f& a, const XrVector3f& b) {
    return XrVector3f{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  };
  XrVector3f t = cross(u, v);
  t = {2 * t.x, 2 * t.y, 2 * t.z};
  const XrVector3f w = cross(u, t);
  return {v.x + q.w * t.x + w.x, v.y + q.w * t.y + w.y, v.z + q.w * t.z + w.z};
}
XrPosef moved(const XrPosef& p, const XrVector3f& by) {
  const XrVector3f d = turned(p.orientation, by);
  return {p.orientation, {p.position.x + d.x, p.position.y + d.y, p.position.z + d.z}};
}

// ---- Instance

XrResult extensions(const char* layer, uint32_t room, uint32_t* count, XrExtensionProperties* to) {
  const auto hold = lock();
  rt().script = read_script();
  std::vector<XrExtensionProperties> all;
  if (!layer)
    for (const char* name : {XR_KHR_OPENGL_ENABLE_EXTENSION_NAME, XR_MNDX_EGL_ENABLE_EXTENSION_NAME,
                             XR_EXT_HAND_TRACKING_EXTENSION_NAME, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME}) {
      if (rt().script.without.contains(name)) continue;
      XrExtensionProperties p{XR_TYPE_EXTENSION_PROPERTIES, nullptr, {}, 1};
      std::strncpy(p.extensionName, name, XR_MAX_EXTENSION_NAME_SIZE - 1);
      all.push_back(p);
    }
  return enumerate(all, room, count, to);
}

XrResult create_instance(const XrInstanceCreateInfo* info, XrInstance* instance) {
  const auto hold = lock();
  Runtime& r = rt();
  r.script = read_script();
  const char* out = std::getenv("LIMBERG_TEST_XR_OUT");
  r.out = out ? out : "";
  MAY_FAIL("xrCreateInstance");
  r.enabled.clear();
  for (uint32_t i = 0; i < info->enabledExtensionCount; ++i) {
    if (r.script.without.contains(info->enabledExtensionNames[i])) return XR_ERROR_EXTENSION_NOT_PRESENT;
    r.enabled.insert(info->enabledExtensionNames[i]);
  }
  r.instance_lost = r.lost = false;
  *instance = reinterpret_cast<XrInstance>(1);
  log("instance");
  return XR_SUCCESS;
}
XrResult destroy_instance(XrInstance) {
  const auto hold = lock();
  log(std::string("instance destroyed") + (rt().have_session ? ", with a session left" : ""));
  return XR_SUCCESS;
}
XrResult instance_properties(XrInstance, XrInstanceProperties* p) {
  p->runtimeVersion = XR_MAKE_VERSION(1, 0, 0);
  std::strcpy(p->runtimeName, "runtime of the tests");
  return XR_SUCCESS;
}
XrResult poll_event(XrInstance, XrEventDataBuffer* to) {
  const auto hold = lock();
  if (rt().instance_lost) return XR_ERROR_INSTANCE_LOST;
  if (rt().events.empty()) return XR_EVENT_UNAVAILABLE;
  *to = rt().events.front();
  rt().events.pop_front();
  return XR_SUCCESS;
}
XrResult result_text(XrInstance, XrResult value, char* to) {
  std::snprintf(to, XR_MAX_RESULT_STRING_SIZE, "XrResult %d", int(value));
  return XR_SUCCESS;
}
XrResult string_to_path(XrInstance, const char* text, XrPath* to) {
  const auto hold = lock();
  auto& paths = rt().paths;
  const auto found = std::find(paths.begin(), paths.end(), text);
  *to = XrPath(found - paths.begin()) + 1;
  if (found == paths.end()) paths.emplace_back(text);
  return XR_SUCCESS;
}
XrResult path_to_string(XrInstance, XrPath path, uint32_t room, uint32_t* count, char* to) {
  const auto hold = lock();
  if (path == 0 || path > rt().paths.size()) return XR_ERROR_PATH_INVALID;
  const std::string& s = rt().paths[path - 1];
  return enumerate(std::vector<char>(s.c_str(), s.c_str() + s.size() + 1), room, count, to);
}
std::string name_of(XrPath path) { return path == 0 || path > rt().paths.size() ? "" : rt().paths[path - 1]; }

// ---- System

XrResult system_of(XrInstance, const XrSystemGetInfo* wanted, XrSystemId* id) {
  const auto hold = lock();
  if (wanted->formFactor != XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY) return XR_ERROR_FORM_FACTOR_UNSUPPORTED;
  if (rt().script.without.contains("headset")) return XR_ERROR_FORM_FACTOR_UNAVAILABLE;
  *id = kSystem;
  return XR_SUCCESS;
}
XrResult system_properties(XrInstance, XrSystemId id, XrSystemProperties* p) {
  const auto hold = lock();
  if (id != kSystem) return XR_ERROR_SYSTEM_INVALID;
  p->systemId = id;
  std::strcpy(p->systemName, "headset of the tests");
  p->graphicsProperties = {4096, 4096, 16};
  p->trackingProperties = {XR_TRUE, XR_TRUE};
  for (auto* n = static_cast<XrBaseOutStructure*>(p->next); n; n = n->next)
    if (n->type == XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT)
      reinterpret_cast<XrSystemHandTrackingPropertiesEXT*>(n)->supportsHandTracking =
          !rt().script.without.contains("hands");
  return XR_SUCCESS;
}
XrResult blend_modes(XrInstance, XrSystemId, XrViewConfigurationType, uint32_t room, uint32_t* count,
                     XrEnvironmentBlendMode* to) {
  return enumerate<XrEnvironmentBlendMode>({XR_ENVIRONMENT_BLEND_MODE_OPAQUE}, room, count, to);
}
XrResult view_configurations(XrInstance, XrSystemId, uint32_t room, uint32_t* count, XrViewConfigurationType* to) {
  return enumerate<XrViewConfigurationType>({XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO}, room, count, to);
}
XrResult view_configuration(XrInstance, XrSystemId, XrViewConfigurationType type, XrViewConfigurationProperties* p) {
  p->viewConfigurationType = type, p->fovMutable = XR_FALSE;
  return XR_SUCCESS;
}
XrResult views(XrInstance, XrSystemId, XrViewConfigurationType type, uint32_t room, uint32_t* count,
               XrViewConfigurationView* to) {
  const auto hold = lock();
  if (type != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO) return XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED;
  const XrViewConfigurationView v{
      XR_TYPE_VIEW_CONFIGURATION_VIEW, nullptr, rt().script.width, 4096, rt().script.height, 4096, 1, 4};
  return enumerate<XrViewConfigurationView>({v, v}, room, count, to);
}
XrResult requirements(XrInstance, XrSystemId, XrGraphicsRequirementsOpenGLKHR* r) {
  r->minApiVersionSupported = XR_MAKE_VERSION(3, 3, 0), r->maxApiVersionSupported = XR_MAKE_VERSION(4, 6, 0);
  return XR_SUCCESS;
}

// ---- Session

XrResult create_session(XrInstance, const XrSessionCreateInfo* info, XrSession* session) {
  const auto hold = lock();
  Runtime& r = rt();
  MAY_FAIL("xrCreateSession");
  if (r.have_session) return XR_ERROR_LIMIT_REACHED;
  const auto* base = static_cast<const XrBaseInStructure*>(info->next);
  void* (*address)(const char*) = nullptr;
  if (base && base->type == XR_TYPE_GRAPHICS_BINDING_EGL_MNDX && r.enabled.contains("XR_MNDX_egl_enable")) {
    const auto* b = reinterpret_cast<const XrGraphicsBindingEGLMNDX*>(base);
    r.egl = true, r.egl_context = b->context;
    if (!b->display || !b->context || !b->getProcAddress) return XR_ERROR_GRAPHICS_DEVICE_INVALID;
    address = reinterpret_cast<void* (*)(const char*)>(b->getProcAddress);
  } else if (base && base->type == XR_TYPE_GRAPHICS_BINDING_OPENGL_XLIB_KHR) {
    const auto* b = reinterpret_cast<const XrGraphicsBindingOpenGLXlibKHR*>(base);
    r.egl = false, r.glx_context = b->glxContext;
    if (!b->xDisplay || !b->glxContext || !b->glxFBConfig || !b->glxDrawable) return XR_ERROR_GRAPHICS_DEVICE_INVALID;
    address = [](const char* n) {
      return reinterpret_cast<void*>(glXGetProcAddressARB(reinterpret_cast<const GLubyte*>(n)));
    };
  } else {
    return XR_ERROR_GRAPHICS_DEVICE_INVALID;
  }
  const auto get = [&](auto& f, const char* name) { f = reinterpret_cast<std::decay_t<decltype(f)>>(address(name)); };
  get(r.gl.GenTextures, "glGenTextures"), get(r.gl.DeleteTextures, "glDeleteTextures");
  get(r.gl.BindTexture, "glBindTexture"), get(r.gl.TexImage2D, "glTexImage2D");
  get(r.gl.GetTexImage, "glGetTexImage"), get(r.gl.GetIntegerv, "glGetIntegerv");
  get(r.gl.PixelStorei, "glPixelStorei");
  r.have_session = true, r.running = r.in_frame = r.exiting = r.ended = r.lost = r.attached = false;
  ++r.sessions;
  r.session_ns = now_ns(), r.frame = r.waited = 0, r.last_shown_ns = r.session_ns;
  r.events.clear();
  *session = reinterpret_cast<XrSession>(3);
  log(std::string("session ") + (r.egl ? "EGL" : "GLX"));
  state_changed(XR_SESSION_STATE_IDLE), state_changed(XR_SESSION_STATE_READY);
  return XR_SUCCESS;
}
XrResult destroy_session(XrSession) {
  const auto hold = lock();
  rt().have_session = false;
  rt().spaces.clear(), rt().swapchains.clear(), rt().trackers.clear();
  log("session destroyed after " + std::to_string(rt().frame) + " frames");
  return XR_SUCCESS;
}
XrResult begin_session(XrSession, const XrSessionBeginInfo*) {
  const auto hold = lock();
  SESSION_LIVES();
  MAY_FAIL("xrBeginSession");
  rt().running = true;
  for (const XrSessionState s : {XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_FOCUSED})
    state_changed(s);
  return XR_SUCCESS;
}
XrResult end_session(XrSession) {
  const auto hold = lock();
  SESSION_LIVES();
  rt().running = false;
  state_changed(XR_SESSION_STATE_IDLE);
  if (rt().exiting) state_changed(XR_SESSION_STATE_EXITING);
  return XR_SUCCESS;
}
XrResult request_exit(XrSession) {
  const auto hold = lock();
  SESSION_LIVES();
  if (!rt().running) return XR_ERROR_SESSION_NOT_RUNNING;
  rt().exiting = true;
  state_changed(XR_SESSION_STATE_STOPPING);
  return XR_SUCCESS;
}

bool context_is_current() {
  return rt().egl ? eglGetCurrentContext() == rt().egl_context : glXGetCurrentContext() == rt().glx_context;
}

// ---- Spaces

XrResult reference_spaces(XrSession, uint32_t room, uint32_t* count, XrReferenceSpaceType* to) {
  const auto hold = lock();
  std::vector<XrReferenceSpaceType> all{XR_REFERENCE_SPACE_TYPE_VIEW, XR_REFERENCE_SPACE_TYPE_LOCAL};
  if (!rt().script.without.contains("stage")) all.push_back(XR_REFERENCE_SPACE_TYPE_STAGE);
  return enumerate(all, room, count, to);
}
template <class H>
H make_handle() {
  return reinterpret_cast<H>(rt().next_handle++);
}
template <class H>
uint64_t number_of(H h) {
  return reinterpret_cast<uint64_t>(h);
}
XrResult create_reference_space(XrSession, const XrReferenceSpaceCreateInfo* info, XrSpace* to) {
  const auto hold = lock();
  *to = make_handle<XrSpace>();
  rt().spaces[number_of(*to)].kind = info->referenceSpaceType == XR_REFERENCE_SPACE_TYPE_VIEW    ? Space::view
                                     : info->referenceSpaceType == XR_REFERENCE_SPACE_TYPE_STAGE ? Space::stage
                                                                                                 : Space::local;
  return XR_SUCCESS;
}
XrResult create_action_space(XrSession, const XrActionSpaceCreateInfo* info, XrSpace* to) {
  const auto hold = lock();
  *to = make_handle<XrSpace>();
  rt().spaces[number_of(*to)] = {Space::of_hand, info->subactionPath};
  return XR_SUCCESS;
}
XrResult destroy_space(XrSpace s) {
  const auto hold = lock();
  rt().spaces.erase(number_of(s));
  return XR_SUCCESS;
}
// The room's frame is that of stage and local space alike.
XrResult locate_space(XrSpace space, XrSpace, XrTime time, XrSpaceLocation* to) {
  const auto hold = lock();
  SESSION_LIVES();
  if (time <= 0) return XR_ERROR_TIME_INVALID;
  const Space& s = rt().spaces[number_of(space)];
  Key k = s.kind == Space::view ? head_at(time)
          : s.kind == Space::of_hand
              ? at(rt().script.path[name_of(s.hand) == "/user/hand/left" ? "left" : "right"], since_session(time))
              : Key{};
  to->locationFlags = !k.on ? 0
                            : XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT |
                                  XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_TRACKED_BIT;
  to->pose = k.pose;
  return XR_SUCCESS;
}

// ---- Swapchains

XrResult formats(XrSession, uint32_t room, uint32_t* count, int64_t* to) {
  return enumerate<int64_t>({GL_RGBA16F, GL_SRGB8_ALPHA8, GL_RGBA8}, room, count, to);
}
XrResult create_swapchain(XrSession, const XrSwapchainCreateInfo* info, XrSwapchain* to) {
  const auto hold = lock();
  SESSION_LIVES();
  MAY_FAIL("xrCreateSwapchain");
  if (!context_is_current()) return XR_ERROR_RUNTIME_FAILURE;
  Runtime& r = rt();
  Swapchain s;
  s.width = info->width, s.height = info->height;
  GLint bound = 0;
  r.gl.GetIntegerv(GL_TEXTURE_BINDING_2D, &bound);
  r.gl.GenTextures(GLsizei(s.texture.size()), s.texture.data());
  for (const GLuint t : s.texture) {
    r.gl.BindTexture(GL_TEXTURE_2D, t);
    r.gl.TexImage2D(GL_TEXTURE_2D, 0, GLint(info->format), GLsizei(s.width), GLsizei(s.height), 0, GL_RGBA,
                    GL_UNSIGNED_BYTE, nullptr);
  }
  r.gl.BindTexture(GL_TEXTURE_2D, GLuint(bound));
  *to = make_handle<XrSwapchain>();
  r.swapchains[number_of(*to)] = s;
  log("swapchain " + std::to_string(s.width) + " x " + std::to_string(s.height) + ", format " +
      std::to_string(info->format));
  return XR_SUCCESS;
}
XrResult destroy_swapchain(XrSwapchain s) {
  const auto hold = lock();
  if (context_is_current()) rt().gl.DeleteTextures(3, rt().swapchains[number_of(s)].texture.data());
  rt().swapchains.erase(number_of(s));
  return XR_SUCCESS;
}
XrResult swapchain_images(XrSwapchain chain, uint32_t room, uint32_t* count, XrSwapchainImageBaseHeader* to) {
  const auto hold = lock();
  const Swapchain& s = rt().swapchains[number_of(chain)];
  *count = uint32_t(s.texture.size());
  if (room == 0) return XR_SUCCESS;
  if (room < *count) return XR_ERROR_SIZE_INSUFFICIENT;
  auto* images = reinterpret_cast<XrSwapchainImageOpenGLKHR*>(to);
  for (size_t i = 0; i < s.texture.size(); ++i) images[i].image = s.texture[i];
  return XR_SUCCESS;
}
XrResult acquire(XrSwapchain chain, const XrSwapchainImageAcquireInfo*, uint32_t* index) {
  const auto hold = lock();
  SESSION_LIVES();
  Swapchain& s = rt().swapchains[number_of(chain)];
  if (s.acquired.size() >= s.texture.size()) return XR_ERROR_CALL_ORDER_INVALID;
  *index = s.next;
  s.next = (s.next + 1) % uint32_t(s.texture.size());
  s.acquired.push_back(*index);
  return XR_SUCCESS;
}
XrResult wait_image(XrSwapchain chain, const XrSwapchainImageWaitInfo*) {
  const auto hold = lock();
  SESSION_LIVES();
  Swapchain& s = rt().swapchains[number_of(chain)];
  if (s.acquired.empty() || s.waited) return XR_ERROR_CALL_ORDER_INVALID;
  s.waited = true;
  return XR_SUCCESS;
}
XrResult release(XrSwapchain chain, const XrSwapchainImageReleaseInfo*) {
  const auto hold = lock();
  SESSION_LIVES();
  Swapchain& s = rt().swapchains[number_of(chain)];
  if (!s.waited || !context_is_current()) return XR_ERROR_CALL_ORDER_INVALID;
  s.released = s.acquired.front();
  s.acquired.pop_front();
  s.waited = false;
  return XR_SUCCESS;
}

// ---- Frames

XrResult wait_frame(XrSession, const XrFrameWaitInfo*, XrFrameState* state) {
  int64_t until = 0;
  {
    const auto hold = lock();
    SESSION_LIVES();
    if (!rt().running) return XR_ERROR_SESSION_NOT_RUNNING;
    MAY_FAIL("xrWaitFrame");
    const int64_t period = int64_t(rt().script.period_ms * 1e6), now = now_ns();
    // Shown two periods after the frame may begin.
    int64_t begin = rt().last_shown_ns - period;
    if (begin < now) begin += (now - begin + period - 1) / period * period;
    if (rt().script.fast) begin = std::max(now, rt().last_shown_ns - period + 1);
    until = rt().script.fast ? now : begin;
    rt().shown_ns = rt().last_shown_ns = begin + 2 * period;
    state->predictedDisplayTime = rt().shown_ns, state->predictedDisplayPeriod = period;
    state->shouldRender = XR_TRUE;
    ++rt().waited;
  }
  const timespec ts{until / kNsPerS, until % kNsPerS};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &ts, nullptr);
  return XR_SUCCESS;
}
XrResult begin_frame(XrSession, const XrFrameBeginInfo*) {
  const auto hold = lock();
  SESSION_LIVES();
  if (rt().waited == 0 || rt().in_frame) return XR_ERROR_CALL_ORDER_INVALID;
  rt().waited = 0, rt().in_frame = true;
  return XR_SUCCESS;
}

const XrFovf kFov[2] = {{-0.80f, 0.62f, 0.70f, -0.75f}, {-0.62f, 0.80f, 0.70f, -0.75f}};
constexpr float kEyesApart_m = 0.063f;

XrResult locate_views(XrSession, const XrViewLocateInfo* info, XrViewState* state, uint32_t room, uint32_t* count,
                      XrView* to) {
  const auto hold = lock();
  SESSION_LIVES();
  *count = 2;
  if (room == 0) return XR_SUCCESS;
  state->viewStateFlags = XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT |
                          XR_VIEW_STATE_ORIENTATION_TRACKED_BIT | XR_VIEW_STATE_POSITION_TRACKED_BIT;
  const XrPosef head = head_at(info->displayTime).pose;
  for (uint32_t i = 0; i < 2; ++i) {
    to[i].pose = moved(head, {(i == 0 ? -0.5f : 0.5f) * kEyesApart_m, 0, 0});
    to[i].fov = kFov[i];
    rt().given[info->displayTime][i] = to[i].pose;
  }
  while (rt().given.size() > 8) rt().given.erase(rt().given.begin());
  return XR_SUCCESS;
}

void write_ppm(const Swapchain& s, const std::string& file) {
  Runtime& r = rt();
  GLint bound = 0;
  r.gl.GetIntegerv(GL_TEXTURE_BINDING_2D, &bound);
  r.gl.BindTexture(GL_TEXTURE_2D, s.texture[size_t(s.released)]);
  std::vector<uint8_t> rgb(3 * size_t(s.width) * s.height);
  r.gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  r.gl.GetTexImage(GL_TEXTURE_2D, 0, GL_RGB, GL_UNSIGNED_BYTE, rgb.data());
  r.gl.BindTexture(GL_TEXTURE_2D, GLuint(bound));
  std::ofstream out(file, std::ios::binary);
  out << "P6\n" << s.width << " " << s.height << "\n255\n";
  for (uint32_t y = 0; y < s.height; ++y)  // the lowest row comes first
    out.write(reinterpret_cast<const char*>(&rgb[3 * size_t(s.width) * (s.height - 1 - y)]), 3 * int64_t(s.width));
}

bool same(const XrPosef& a, const XrPosef& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

XrResult end_frame(XrSession, const XrFrameEndInfo* info) {
  const auto hold = lock();
  SESSION_LIVES();
  Runtime& r = rt();
  MAY_FAIL("xrEndFrame");
  if (!r.in_frame) return XR_ERROR_CALL_ORDER_INVALID;
  r.in_frame = false;
  if (info->displayTime != r.shown_ns) return XR_ERROR_TIME_INVALID;
  std::ostringstream line;
  line << "frame " << r.frame << " at_s " << since_session(info->displayTime) << " layers " << info->layerCount;
  for (uint32_t l = 0; l < info->layerCount; ++l) {
    if (!info->layers[l] || info->layers[l]->type != XR_TYPE_COMPOSITION_LAYER_PROJECTION) continue;
    const auto* p = reinterpret_cast<const XrCompositionLayerProjection*>(info->layers[l]);
    if (p->viewCount != 2) return XR_ERROR_LAYER_INVALID;
    for (uint32_t i = 0; i < 2; ++i) {
      const XrCompositionLayerProjectionView& v = p->views[i];
      Swapchain& s = r.swapchains[number_of(v.subImage.swapchain)];
      if (s.released < 0 || !s.acquired.empty()) return XR_ERROR_LAYER_INVALID;
      if (!same(v.pose, r.given[info->displayTime][i])) return XR_ERROR_POSE_INVALID;
      const std::string eye = i == 0 ? "left" : "right";
      if (!r.out.empty() && context_is_current() && r.script.keep.contains(r.frame))
        write_ppm(s, r.out + "/frame-" + std::to_string(r.frame) + "-" + eye + ".ppm");
      if (!r.out.empty() && context_is_current() && r.script.keep_last) write_ppm(s, r.out + "/last-" + eye + ".ppm");
    }
  }
  log(line.str());
  if (r.frame == 0) r.session_ns = now_ns();
  if (r.script.end_s >= 0 && r.sessions == r.script.end_session && since_session(now_ns()) >= r.script.end_s)
    r.script.end_s = -1, std::raise(SIGINT);
  for (const std::string& e : r.script.at_frame[r.frame]) {
    if (e == "lose") state_changed(XR_SESSION_STATE_LOSS_PENDING), r.lost = true;
    if (e == "lose_instance") r.instance_lost = true;
    if (e == "stop") state_changed(XR_SESSION_STATE_STOPPING);
    if (e == "exit") r.exiting = true, state_changed(XR_SESSION_STATE_STOPPING);
  }
  ++r.frame;
  return XR_SUCCESS;
}

// ---- Actions

XrResult create_action_set(XrInstance, const XrActionSetCreateInfo*, XrActionSet* to) {
  const auto hold = lock();
  *to = make_handle<XrActionSet>();
  return XR_SUCCESS;
}
XrResult destroy_action_set(XrActionSet) { return XR_SUCCESS; }
XrResult create_action(XrActionSet, const XrActionCreateInfo* info, XrAction* to) {
  const auto hold = lock();
  *to = make_handle<XrAction>();
  rt().actions[number_of(*to)] = {info->actionName, info->actionType};
  return XR_SUCCESS;
}
XrResult destroy_action(XrAction) { return XR_SUCCESS; }
XrResult suggest(XrInstance, const XrInteractionProfileSuggestedBinding* b) {
  const auto hold = lock();
  if (rt().attached) return XR_ERROR_ACTIONSETS_ALREADY_ATTACHED;
  log("profile " + name_of(b->interactionProfile) + ", " + std::to_string(b->countSuggestedBindings) + " bindings");
  return XR_SUCCESS;
}
XrResult attach(XrSession, const XrSessionActionSetsAttachInfo*) {
  const auto hold = lock();
  rt().attached = true;
  return XR_SUCCESS;
}
XrResult current_profile(XrSession, XrPath, XrInteractionProfileState* s) {
  s->interactionProfile = XR_NULL_PATH;
  return XR_SUCCESS;
}
XrResult sync(XrSession, const XrActionsSyncInfo*) {
  const auto hold = lock();
  SESSION_LIVES();
  MAY_FAIL("xrSyncActions");
  return rt().focused ? XR_SUCCESS : XR_SESSION_NOT_FOCUSED;
}
Key controller(XrPath hand) {
  return at(rt().script.path[name_of(hand) == "/user/hand/left" ? "left" : "right"], since_session(now_ns()));
}
XrResult state_boolean(XrSession, const XrActionStateGetInfo* info, XrActionStateBoolean* s) {
  const auto hold = lock();
  SESSION_LIVES();
  const Key k = controller(info->subactionPath);
  const std::string& name = rt().actions[number_of(info->action)].name;
  const int which = name == "press" ? 0 : name == "clutch" ? 1 : 2;
  s->isActive = k.on && rt().focused;
  s->currentState = s->isActive && k.extra[which] > 0.5f;
  s->changedSinceLastSync = XR_FALSE, s->lastChangeTime = 0;
  return XR_SUCCESS;
}
XrResult state_pose(XrSession, const XrActionStateGetInfo* info, XrActionStatePose* s) {
  const auto hold = lock();
  SESSION_LIVES();
  s->isActive = controller(info->subactionPath).on && rt().focused;
  return XR_SUCCESS;
}

// ---- Hands, time

XrResult create_hand_tracker(XrSession, const XrHandTrackerCreateInfoEXT* info, XrHandTrackerEXT* to) {
  const auto hold = lock();
  if (!rt().enabled.contains(XR_EXT_HAND_TRACKING_EXTENSION_NAME)) return XR_ERROR_FUNCTION_UNSUPPORTED;
  *to = make_handle<XrHandTrackerEXT>();
  rt().trackers[number_of(*to)] = info->hand == XR_HAND_LEFT_EXT;
  return XR_SUCCESS;
}
XrResult destroy_hand_tracker(XrHandTrackerEXT t) {
  const auto hold = lock();
  rt().trackers.erase(number_of(t));
  return XR_SUCCESS;
}
XrResult locate_joints(XrHandTrackerEXT tracker, const XrHandJointsLocateInfoEXT* info, XrHandJointLocationsEXT* to) {
  const auto hold = lock();
  SESSION_LIVES();
  const Key k =
      at(rt().script.path[rt().trackers[number_of(tracker)] ? "left_hand" : "right_hand"], since_session(info->time));
  to->isActive = k.on;
  for (uint32_t i = 0; i < to->jointCount; ++i) {
    XrHandJointLocationEXT& j = to->jointLocations[i];
    j.locationFlags = k.on ? XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT |
                                 XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_TRACKED_BIT
                           : 0;
    j.pose = i == XR_HAND_JOINT_THUMB_TIP_EXT   ? moved(k.pose, {-k.extra[0], 0, 0})
             : i == XR_HAND_JOINT_INDEX_TIP_EXT ? k.pose
                                                : moved(k.pose, {0, 0, 0.05f});
    j.radius = 0.008f;
  }
  return XR_SUCCESS;
}
XrResult to_time(XrInstance, const timespec* t, XrTime* to) {
  *to = int64_t(t->tv_sec) * kNsPerS + t->tv_nsec;
  return XR_SUCCESS;
}

XrResult address(XrInstance, const char* name, PFN_xrVoidFunction* function);

const std::map<std::string, PFN_xrVoidFunction>& functions() {
  static const std::map<std::string, PFN_xrVoidFunction> all{
      {"xrGetInstanceProcAddr", plain(address)},
      {"xrEnumerateInstanceExtensionProperties", plain(extensions)},
      {"xrCreateInstance", plain(create_instance)},
      {"xrDestroyInstance", plain(destroy_instance)},
      {"xrGetInstanceProperties", plain(instance_properties)},
      {"xrPollEvent", plain(poll_event)},
      {"xrResultToString", plain(result_text)},
      {"xrStringToPath", plain(string_to_path)},
      {"xrPathToString", plain(path_to_string)},
      {"xrGetSystem", plain(system_of)},
      {"xrGetSystemProperties", plain(system_properties)},
      {"xrEnumerateEnvironmentBlendModes", plain(blend_modes)},
      {"xrEnumerateViewConfigurations", plain(view_configurations)},
      {"xrGetViewConfigurationProperties", plain(view_configuration)},
      {"xrEnumerateViewConfigurationViews", plain(views)},
      {"xrGetOpenGLGraphicsRequirementsKHR", plain(requirements)},
      {"xrCreateSession", plain(create_session)},
      {"xrDestroySession", plain(destroy_session)},
      {"xrBeginSession", plain(begin_session)},
      {"xrEndSession", plain(end_session)},
      {"xrRequestExitSession", plain(request_exit)},
      {"xrEnumerateReferenceSpaces", plain(reference_spaces)},
      {"xrCreateReferenceSpace", plain(create_reference_space)},
      {"xrCreateActionSpace", plain(create_action_space)},
      {"xrDestroySpace", plain(destroy_space)},
      {"xrLocateSpace", plain(locate_space)},
      {"xrEnumerateSwapchainFormats", plain(formats)},
      {"xrCreateSwapchain", plain(create_swapchain)},
      {"xrDestroySwapchain", plain(destroy_swapchain)},
      {"xrEnumerateSwapchainImages", plain(swapchain_images)},
      {"xrAcquireSwapchainImage", plain(acquire)},
      {"xrWaitSwapchainImage", plain(wait_image)},
      {"xrReleaseSwapchainImage", plain(release)},
      {"xrWaitFrame", plain(wait_frame)},
      {"xrBeginFrame", plain(begin_frame)},
      {"xrEndFrame", plain(end_frame)},
      {"xrLocateViews", plain(locate_views)},
      {"xrCreateActionSet", plain(create_action_set)},
      {"xrDestroyActionSet", plain(destroy_action_set)},
      {"xrCreateAction", plain(create_action)},
      {"xrDestroyAction", plain(destroy_action)},
      {"xrSuggestInteractionProfileBindings", plain(suggest)},
      {"xrAttachSessionActionSets", plain(attach)},
      {"xrGetCurrentInteractionProfile", plain(current_profile)},
      {"xrSyncActions", plain(sync)},
      {"xrGetActionStateBoolean", plain(state_boolean)},
      {"xrGetActionStatePose", plain(state_pose)},
      {"xrCreateHandTrackerEXT", plain(create_hand_tracker)},
      {"xrDestroyHandTrackerEXT", plain(destroy_hand_tracker)},
      {"xrLocateHandJointsEXT", plain(locate_joints)},
      {"xrConvertTimespecTimeToTimeKHR", plain(to_time)}};
  return all;
}

XrResult address(XrInstance, const char* name, PFN_xrVoidFunction* function) {
  const auto found = functions().find(name);
  *function = found == functions().end() ? nullptr : found->second;
  return *function ? XR_SUCCESS : XR_ERROR_FUNCTION_UNSUPPORTED;
}

}  // namespace

extern "C" XRAPI_ATTR XrResult XRAPI_CALL xrNegotiateLoaderRuntimeInterface(const XrNegotiateLoaderInfo* loader,
                                                                            XrNegotiateRuntimeRequest* request) {
  if (!loader || !request || loader->minInterfaceVersion > kInterface) return XR_ERROR_INITIALIZATION_FAILED;
  request->runtimeInterfaceVersion = kInterface;
  request->runtimeApiVersion = XR_CURRENT_API_VERSION;
  request->getInstanceProcAddr = address;
  return XR_SUCCESS;
}

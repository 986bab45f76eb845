// The part limberg-openxr.so: a session with the runtime of OpenXR 1.0 that the loader finds. Section numbers and rules
// are those of the OpenXR 1.0 specification.
//
// Extensions: XR_KHR_opengl_enable and, where there is one, XR_MNDX_egl_enable (a context without an X server);
// XR_EXT_hand_tracking and XR_KHR_convert_timespec_time where there are.
#define XR_USE_PLATFORM_EGL
#define XR_USE_PLATFORM_XLIB
#define XR_USE_GRAPHICS_API_OPENGL
#define XR_USE_TIMESPEC
#include <EGL/egl.h>
#include <GL/glx.h>
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>
#include <time.h>
// X11's macros are words of others.
#undef None
#undef Always
#undef Success

#include <algorithm>
#include <atomic>
#include <cstring>
#include <initializer_list>
#include <mutex>
#include <utility>
#include <vector>

#include "app/headset/session.h"
#include "devices/monotonic.h"

namespace limberg {

namespace {

template <class T>
T of_type(XrStructureType type) {
  T t{};
  t.type = type;
  return t;
}

template <size_t N>
void copy_name(char (&to)[N], const char* from) {
  std::strncpy(to, from, N - 1);
}

constexpr XrPosef kNowhere{{0, 0, 0, 1}, {0, 0, 0}};
constexpr int64_t kSrgb8Alpha8 = 0x8C43, kRgba8 = 0x8058;  // of OpenGL

RoomPose pose_of(const XrPosef& p) {
  RoomPose r;
  r.at_m = {double(p.position.x), double(p.position.y), double(p.position.z)};
  r.turned = Eigen::Quaterniond(double(p.orientation.w), double(p.orientation.x), double(p.orientation.y),
                                double(p.orientation.z));
  if (!(r.turned.norm() > 0.5)) r.turned.setIdentity();
  r.turned.normalize();
  return r;
}

bool known(XrSpaceLocationFlags flags) {
  constexpr XrSpaceLocationFlags kBoth = XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;
  return (flags & kBoth) == kBoth;
}

class OpenXrSession final : public HeadsetSession {
 public:
  explicit OpenXrSession(const MakeContext& make_context) {
    try {
      make_instance();
      find_system();
      make_session(make_context);
      make_space();
      make_actions();
      make_hand_trackers();
      make_swapchains();
    } catch (...) {
      let_go();
      throw;
    }
  }
  ~OpenXrSession() override { let_go(); }

  const HeadsetFacts& facts() const override { return facts_; }
  Step step(HeadsetPainter& painter) override;
  void end() override {
    if (running_ && !lost_) xrRequestExitSession(session_);
  }
  bool read(HandsReading& reading) override;

 private:
  struct Chain {
    XrSwapchain handle = XR_NULL_HANDLE;
    int width = 0, height = 0;
    std::vector<XrSwapchainImageOpenGLKHR> image;
  };
  enum { kLeft = 0, kRight = 1 };

  void check(XrResult result, const char* what) const;
  template <class F>
  F function(const char* name) const {
    PFN_xrVoidFunction f = nullptr;
    check(xrGetInstanceProcAddr(instance_, name, &f), name);
    return reinterpret_cast<F>(f);
  }
  void make_instance();
  void find_system();
  void make_session(const MakeContext& make_context);
  void make_space();
  void make_actions();
  void make_hand_trackers();
  void make_swapchains();
  void let_go();
  void hear();
  void frame(HeadsetPainter& painter);
  bool see(XrTime at, HeadsetFrame& frame);
  void paint_eye(HeadsetPainter& painter, size_t which);
  XrPath path(const char* text) const {
    XrPath p = XR_NULL_PATH;
    check(xrStringToPath(instance_, text, &p), text);
    return p;
  }
  XrTime now(int64_t& monotonic) const;
  bool pressed(XrAction action, size_t hand) const;

  HeadsetFacts facts_;
  XrInstance instance_ = XR_NULL_HANDLE;
  XrSystemId system_ = XR_NULL_SYSTEM_ID;
  XrSession session_ = XR_NULL_HANDLE;
  XrSpace room_ = XR_NULL_HANDLE;
  bool egl_ = false, fingers_ = false, clock_ = false;  // what the runtime has
  std::array<Chain, 2> chain_;
  std::array<XrView, 2> view_{};
  std::atomic<bool> running_{false}, focused_{false}, lost_{false};
  bool ended_ = false;
  std::string why_;
  std::atomic<int64_t> ahead_ns_{0};  // of the runtime's clock, where it does not convert times

  XrActionSet actions_ = XR_NULL_HANDLE;
  XrAction aim_ = XR_NULL_HANDLE, press_ = XR_NULL_HANDLE, clutch_ = XR_NULL_HANDLE, place_ = XR_NULL_HANDLE;
  std::array<XrPath, 2> hand_{};
  std::array<XrSpace, 2> aim_space_{};
  std::array<XrHandTrackerEXT, 2> tracker_{};
  PFN_xrLocateHandJointsEXT locate_joints_ = nullptr;
  PFN_xrDestroyHandTrackerEXT destroy_tracker_ = nullptr;
  PFN_xrConvertTimespecTimeToTimeKHR to_time_ = nullptr;
};

void OpenXrSession::check(XrResult result, const char* what) const {
  if (XR_SUCCEEDED(result)) return;
  char name[XR_MAX_RESULT_STRING_SIZE] = "";
  if (instance_ == XR_NULL_HANDLE || XR_FAILED(xrResultToString(instance_, result, name)))
    std::strcpy(name, ("OpenXR error " + std::to_string(int(result))).c_str());
  if (result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST || result == XR_ERROR_RUNTIME_UNAVAILABLE)
    throw RenderUnavailable(std::string("the headset is gone: ") + what + " (" + name + ")");
  throw RenderUnavailable(std::string("no headset: ") + what + " (" + name + ")");
}

void OpenXrSession::make_instance() {
  uint32_t n = 0;
  std::vector<XrExtensionProperties> offered;
  check(xrEnumerateInstanceExtensionProperties(nullptr, 0, &n, nullptr),
        "no OpenXR runtime answers; expected one installed, or XR_RUNTIME_JSON to name its manifest");
  offered.assign(n, of_type<XrExtensionProperties>(XR_TYPE_EXTENSION_PROPERTIES));
  check(xrEnumerateInstanceExtensionProperties(nullptr, n, &n, offered.data()), "the runtime names no extensions");
  std::vector<const char*> wanted;
  const auto want = [&](const char* name) {
    const bool there = std::any_of(offered.begin(), offered.end(),
                                   [&](const auto& e) { return std::strcmp(e.extensionName, name) == 0; });
    if (there) wanted.push_back(name);
    return there;
  };
  if (!want(XR_KHR_OPENGL_ENABLE_EXTENSION_NAME))
    throw RenderUnavailable("no headset: its runtime takes no pictures of OpenGL; expected XR_KHR_opengl_enable");
  egl_ = want(XR_MNDX_EGL_ENABLE_EXTENSION_NAME);
  fingers_ = want(XR_EXT_HAND_TRACKING_EXTENSION_NAME);
  clock_ = want(XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME);

  auto create = of_type<XrInstanceCreateInfo>(XR_TYPE_INSTANCE_CREATE_INFO);
  copy_name(create.applicationInfo.applicationName, "Limberg");
  create.applicationInfo.applicationVersion = 1;
  create.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
  create.enabledExtensionCount = uint32_t(wanted.size()), create.enabledExtensionNames = wanted.data();
  check(xrCreateInstance(&create, &instance_), "its runtime does not start");
  auto runtime = of_type<XrInstanceProperties>(XR_TYPE_INSTANCE_PROPERTIES);
  check(xrGetInstanceProperties(instance_, &runtime), "the runtime does not say what it is");
  facts_.runtime = runtime.runtimeName;
  if (clock_) to_time_ = function<PFN_xrConvertTimespecTimeToTimeKHR>("xrConvertTimespecTimeToTimeKHR");
}

void OpenXrSession::find_system() {
  auto wanted = of_type<XrSystemGetInfo>(XR_TYPE_SYSTEM_GET_INFO);
  wanted.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
  check(xrGetSystem(instance_, &wanted, &system_), "the runtime has no head-mounted display; expected one plugged in");
  auto hands = of_type<XrSystemHandTrackingPropertiesEXT>(XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT);
  auto properties = of_type<XrSystemProperties>(XR_TYPE_SYSTEM_PROPERTIES);
  if (fingers_) properties.next = &hands;
  check(xrGetSystemProperties(instance_, system_, &properties), "the headset does not say what it is");
  facts_.system = properties.systemName;
  fingers_ = fingers_ && hands.supportsHandTracking;
  facts_.hands = fingers_;
}

void OpenXrSession::make_session(const MakeContext& make_context) {
  auto needs = of_type<XrGraphicsRequirementsOpenGLKHR>(XR_TYPE_GRAPHICS_REQUIREMENTS_OPENGL_KHR);
  const auto requirements = function<PFN_xrGetOpenGLGraphicsRequirementsKHR>("xrGetOpenGLGraphicsRequirementsKHR");
  check(requirements(instance_, system_, &needs), "the runtime does not say which OpenGL it takes");
  NativeContext native;
  std::string why;
  for (const NativeContext::Kind kind : {NativeContext::egl, NativeContext::glx}) {
    if (native.kind != NativeContext::none || (kind == NativeContext::egl && !egl_)) continue;
    try {
      native = make_context(kind);
    } catch (const RenderUnavailable& e) {
      why += (why.empty() ? "" : "; ") + std::string(e.what());
    }
  }
  if (native.kind == NativeContext::none) throw RenderUnavailable("no headset: " + why);
  auto create = of_type<XrSessionCreateInfo>(XR_TYPE_SESSION_CREATE_INFO);
  create.systemId = system_;
  auto egl = of_type<XrGraphicsBindingEGLMNDX>(XR_TYPE_GRAPHICS_BINDING_EGL_MNDX);
  auto glx = of_type<XrGraphicsBindingOpenGLXlibKHR>(XR_TYPE_GRAPHICS_BINDING_OPENGL_XLIB_KHR);
  if (native.kind == NativeContext::egl) {
    egl.getProcAddress = native.address;
    egl.display = native.display, egl.config = native.config, egl.context = native.context;
    create.next = &egl;
  } else {
    glx.xDisplay = static_cast<Display*>(native.display);
    glx.visualid = native.visual, glx.glxFBConfig = static_cast<GLXFBConfig>(native.config);
    glx.glxDrawable = native.drawable, glx.glxContext = static_cast<GLXContext>(native.context);
    create.next = &glx;
  }
  facts_.context = native.kind == NativeContext::egl ? "EGL" : "GLX";
  check(xrCreateSession(instance_, &create, &session_), "the runtime refuses a session");
}

void OpenXrSession::make_space() {
  uint32_t n = 0;
  check(xrEnumerateReferenceSpaces(session_, 0, &n, nullptr), "the runtime names no spaces");
  std::vector<XrReferenceSpaceType> all(n);
  check(xrEnumerateReferenceSpaces(session_, n, &n, all.data()), "the runtime names no spaces");
  facts_.floor = std::find(all.begin(), all.end(), XR_REFERENCE_SPACE_TYPE_STAGE) != all.end();
  auto create = of_type<XrReferenceSpaceCreateInfo>(XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
  create.referenceSpaceType = facts_.floor ? XR_REFERENCE_SPACE_TYPE_STAGE : XR_REFERENCE_SPACE_TYPE_LOCAL;
  create.poseInReferenceSpace = kNowhere;
  check(xrCreateReferenceSpace(session_, &create, &room_), "the runtime has no room");
}

void OpenXrSession::make_actions() {
  auto set = of_type<XrActionSetCreateInfo>(XR_TYPE_ACTION_SET_CREATE_INFO);
  copy_name(set.actionSetName, "operating"), copy_name(set.localizedActionSetName, "Operating");
  check(xrCreateActionSet(instance_, &set, &actions_), "no set of actions can be made");
  hand_ = {path("/user/hand/left"), path("/user/hand/right")};
  const auto action = [&](XrActionType type, const char* name, const char* words) {
    auto a = of_type<XrActionCreateInfo>(XR_TYPE_ACTION_CREATE_INFO);
    a.actionType = type;
    copy_name(a.actionName, name), copy_name(a.localizedActionName, words);
    a.countSubactionPaths = 2, a.subactionPaths = hand_.data();
    XrAction made = XR_NULL_HANDLE;
    check(xrCreateAction(actions_, &a, &made), name);
    return made;
  };
  aim_ = action(XR_ACTION_TYPE_POSE_INPUT, "aim", "The tool");
  press_ = action(XR_ACTION_TYPE_BOOLEAN_INPUT, "press", "Press the tool, close the hand");
  clutch_ = action(XR_ACTION_TYPE_BOOLEAN_INPUT, "clutch", "Clutch");
  place_ = action(XR_ACTION_TYPE_BOOLEAN_INPUT, "place", "Put the patient before me");

  // Section 6.4: a runtime takes those that it knows.
  struct Profile {
    const char *name, *press, *clutch, *place;
  };
  constexpr Profile kProfiles[] = {{"khr/simple_controller", "select/click", nullptr, "menu/click"},
                                   {"oculus/touch_controller", "trigger/value", "squeeze/value", nullptr},
                                   {"valve/index_controller", "trigger/value", "squeeze/value", "b/click"},
                                   {"htc/vive_controller", "trigger/click", "squeeze/click", "menu/click"},
                                   {"microsoft/motion_controller", "trigger/value", "squeeze/click", "menu/click"}};
  for (const Profile& p : kProfiles) {
    std::vector<XrActionSuggestedBinding> bindings;
    for (const std::string hand : {"/user/hand/left/input/", "/user/hand/right/input/"}) {
      const auto bind = [&](XrAction a, const char* what) {
        if (what) bindings.push_back({a, path((hand + what).c_str())});
      };
      bind(aim_, "aim/pose"), bind(press_, p.press), bind(clutch_, p.clutch), bind(place_, p.place);
    }
    // Oculus Touch has other buttons on each side.
    if (std::strncmp(p.name, "oculus", 6) == 0) {
      bindings.push_back({place_, path("/user/hand/left/input/y/click")});
      bindings.push_back({place_, path("/user/hand/right/input/b/click")});
    }
    auto suggested = of_type<XrInteractionProfileSuggestedBinding>(XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING);
    suggested.interactionProfile = path(("/interaction_profiles/" + std::string(p.name)).c_str());
    suggested.countSuggestedBindings = uint32_t(bindings.size()), suggested.suggestedBindings = bindings.data();
    const XrResult taken = xrSuggestInteractionProfileBindings(instance_, &suggested);
    if (taken != XR_ERROR_PATH_UNSUPPORTED) check(taken, p.name);
  }
  auto attach = of_type<XrSessionActionSetsAttachInfo>(XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO);
  attach.countActionSets = 1, attach.actionSets = &actions_;
  check(xrAttachSessionActionSets(session_, &attach), "the actions are not taken");
  for (size_t h = 0; h < 2; ++h) {
    auto space = of_type<XrActionSpaceCreateInfo>(XR_TYPE_ACTION_SPACE_CREATE_INFO);
    space.action = aim_, space.subactionPath = hand_[h], space.poseInActionSpace = kNowhere;
    check(xrCreateActionSpace(session_, &space, &aim_space_[h]), "a hand has no place");
  }
}

void OpenXrSession::make_hand_trackers() {
  if (!fingers_) return;
  const auto create = function<PFN_xrCreateHandTrackerEXT>("xrCreateHandTrackerEXT");
  locate_joints_ = function<PFN_xrLocateHandJointsEXT>("xrLocateHandJointsEXT");
  destroy_tracker_ = function<PFN_xrDestroyHandTrackerEXT>("xrDestroyHandTrackerEXT");
  for (size_t h = 0; h < 2; ++h) {
    auto info = of_type<XrHandTrackerCreateInfoEXT>(XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT);
    info.hand = h == kLeft ? XR_HAND_LEFT_EXT : XR_HAND_RIGHT_EXT;
    info.handJointSet = XR_HAND_JOINT_SET_DEFAULT_EXT;
    check(create(session_, &info, &tracker_[h]), "its hands are not tracked");
  }
}

void OpenXrSession::make_swapchains() {
  constexpr XrViewConfigurationType kStereo = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
  uint32_t n = 0;
  check(xrEnumerateViewConfigurationViews(instance_, system_, kStereo, 0, &n, nullptr), "the headset has no two eyes");
  std::vector<XrViewConfigurationView> views(n, of_type<XrViewConfigurationView>(XR_TYPE_VIEW_CONFIGURATION_VIEW));
  check(xrEnumerateViewConfigurationViews(instance_, system_, kStereo, n, &n, views.data()),
        "the headset does not describe its views");
  if (n != 2) throw RenderUnavailable("no headset: it has " + std::to_string(n) + " views; expected two");
  check(xrEnumerateSwapchainFormats(session_, 0, &n, nullptr), "the runtime names no formats");
  std::vector<int64_t> formats(n);
  check(xrEnumerateSwapchainFormats(session_, n, &n, formats.data()), "the runtime names no formats");
  // Pictures are sRGB; a runtime that has no such format takes their bytes for light.
  const bool srgb = std::find(formats.begin(), formats.end(), kSrgb8Alpha8) != formats.end();
  if (!srgb && std::find(formats.begin(), formats.end(), kRgba8) == formats.end())
    throw RenderUnavailable("no headset: its pictures have none of the formats SRGB8_ALPHA8 and RGBA8");
  for (size_t e = 0; e < 2; ++e) {
    Chain& c = chain_[e];
    c.width = int(views[e].recommendedImageRectWidth), c.height = int(views[e].recommendedImageRectHeight);
    auto create = of_type<XrSwapchainCreateInfo>(XR_TYPE_SWAPCHAIN_CREATE_INFO);
    create.usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_SAMPLED_BIT;
    create.format = srgb ? kSrgb8Alpha8 : kRgba8;
    create.sampleCount = create.faceCount = create.arraySize = create.mipCount = 1;
    create.width = uint32_t(c.width), create.height = uint32_t(c.height);
    check(xrCreateSwapchain(session_, &create, &c.handle), "no pictures can be handed over");
    check(xrEnumerateSwapchainImages(c.handle, 0, &n, nullptr), "no pictures can be handed over");
    c.image.assign(n, of_type<XrSwapchainImageOpenGLKHR>(XR_TYPE_SWAPCHAIN_IMAGE_OPENGL_KHR));
    check(xrEnumerateSwapchainImages(c.handle, n, &n, reinterpret_cast<XrSwapchainImageBaseHeader*>(c.image.data())),
          "no pictures can be handed over");
    view_[e] = of_type<XrView>(XR_TYPE_VIEW);
  }
  facts_.width = chain_[0].width, facts_.height = chain_[0].height;
}

// Children before parents. What answers that it is lost is gone as well.
void OpenXrSession::let_go() {
  for (const XrHandTrackerEXT t : tracker_)
    if (t != XR_NULL_HANDLE) destroy_tracker_(t);
  for (const XrSpace s : aim_space_)
    if (s != XR_NULL_HANDLE) xrDestroySpace(s);
  for (const Chain& c : chain_)
    if (c.handle != XR_NULL_HANDLE) xrDestroySwapchain(c.handle);
  if (room_ != XR_NULL_HANDLE) xrDestroySpace(room_);
  if (session_ != XR_NULL_HANDLE) xrDestroySession(session_);
  for (const XrAction a : {aim_, press_, clutch_, place_})
    if (a != XR_NULL_HANDLE) xrDestroyAction(a);
  if (actions_ != XR_NULL_HANDLE) xrDestroyActionSet(actions_);
  if (instance_ != XR_NULL_HANDLE) xrDestroyInstance(instance_);
}

/// Section 9: the runtime leads the session from state to state.
void OpenXrSession::hear() {
  for (;;) {
    auto buffer = of_type<XrEventDataBuffer>(XR_TYPE_EVENT_DATA_BUFFER);
    const XrResult result = xrPollEvent(instance_, &buffer);
    if (result == XR_EVENT_UNAVAILABLE) return;
    check(result, "the runtime is silent");
    if (buffer.type == XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING) {
      lost_ = true, why_ = "its runtime ends";
      continue;
    }
    if (buffer.type != XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) continue;
    const XrSessionState state = reinterpret_cast<const XrEventDataSessionStateChanged&>(buffer).state;
    focused_ = state == XR_SESSION_STATE_FOCUSED;
    if (state == XR_SESSION_STATE_READY) {
      auto begin = of_type<XrSessionBeginInfo>(XR_TYPE_SESSION_BEGIN_INFO);
      begin.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
      check(xrBeginSession(session_, &begin), "the session does not begin");
      running_ = true;
    } else if (state == XR_SESSION_STATE_STOPPING) {
      running_ = false;
      check(xrEndSession(session_), "the session does not end");
    } else if (state == XR_SESSION_STATE_EXITING) {
      ended_ = true;
    } else if (state == XR_SESSION_STATE_LOSS_PENDING) {
      lost_ = true, why_ = "unplugged, or its runtime was restarted";
    }
  }
}

HeadsetSession::Step OpenXrSession::step(HeadsetPainter& painter) {
  hear();
  if (lost_) {
    focused_ = running_ = false;
    throw RenderUnavailable("the headset is gone: " + why_);
  }
  if (ended_) return Step::ended;
  if (!running_) return Step::idle;
  frame(painter);
  return Step::frame;
}

void OpenXrSession::frame(HeadsetPainter& painter) {
  const auto wait = of_type<XrFrameWaitInfo>(XR_TYPE_FRAME_WAIT_INFO);
  auto state = of_type<XrFrameState>(XR_TYPE_FRAME_STATE);
  check(xrWaitFrame(session_, &wait, &state), "its next frame does not come");
  ahead_ns_ = state.predictedDisplayTime - monotonic_ns();
  const auto begin = of_type<XrFrameBeginInfo>(XR_TYPE_FRAME_BEGIN_INFO);
  check(xrBeginFrame(session_, &begin), "a frame does not begin");

  auto projection = of_type<XrCompositionLayerProjection>(XR_TYPE_COMPOSITION_LAYER_PROJECTION);
  std::array<XrCompositionLayerProjectionView, 2> views{};
  const XrCompositionLayerBaseHeader* layer = nullptr;
  HeadsetFrame f;
  f.seen_ns = state.predictedDisplayTime, f.period_ns = state.predictedDisplayPeriod;
  if (state.shouldRender && see(state.predictedDisplayTime, f) && painter.begin(f)) {
    for (size_t e = 0; e < 2; ++e) {
      paint_eye(painter, e);
      // With the pose that it was drawn for: the runtime turns it to where the head is by then (section 10.6).
      views[e] = of_type<XrCompositionLayerProjectionView>(XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW);
      views[e].pose = view_[e].pose, views[e].fov = view_[e].fov;
      views[e].subImage.swapchain = chain_[e].handle;
      views[e].subImage.imageRect = {{0, 0}, {chain_[e].width, chain_[e].height}};
    }
    projection.space = room_, projection.viewCount = 2, projection.views = views.data();
    layer = reinterpret_cast<const XrCompositionLayerBaseHeader*>(&projection);
  }
  auto end = of_type<XrFrameEndInfo>(XR_TYPE_FRAME_END_INFO);
  end.displayTime = state.predictedDisplayTime, end.environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
  end.layerCount = layer ? 1 : 0, end.layers = layer ? &layer : nullptr;
  check(xrEndFrame(session_, &end), "a frame is not taken");
}

bool OpenXrSession::see(XrTime at, HeadsetFrame& f) {
  auto info = of_type<XrViewLocateInfo>(XR_TYPE_VIEW_LOCATE_INFO);
  info.viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
  info.displayTime = at, info.space = room_;
  auto state = of_type<XrViewState>(XR_TYPE_VIEW_STATE);
  uint32_t n = 0;
  check(xrLocateViews(session_, &info, &state, uint32_t(view_.size()), &n, view_.data()), "its eyes are nowhere");
  constexpr XrViewStateFlags kBoth = XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT;
  if (n != 2 || (state.viewStateFlags & kBoth) != kBoth) return false;
  for (size_t e = 0; e < 2; ++e) {
    f.eye[e].pose = pose_of(view_[e].pose);
    const XrFovf& fov = view_[e].fov;
    f.eye[e].angles = {fov.angleLeft, fov.angleRight, fov.angleUp, fov.angleDown};
  }
  f.head.at_m = 0.5 * (f.eye[0].pose.at_m + f.eye[1].pose.at_m);
  f.head.turned = f.eye[0].pose.turned.slerp(0.5, f.eye[1].pose.turned);
  return true;
}

void OpenXrSession::paint_eye(HeadsetPainter& painter, size_t which) {
  const Chain& c = chain_[which];
  const auto acquire = of_type<XrSwapchainImageAcquireInfo>(XR_TYPE_SWAPCHAIN_IMAGE_ACQUIRE_INFO);
  uint32_t index = 0;
  check(xrAcquireSwapchainImage(c.handle, &acquire, &index), "no picture is free");
  auto wait = of_type<XrSwapchainImageWaitInfo>(XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO);
  wait.timeout = XR_INFINITE_DURATION;
  check(xrWaitSwapchainImage(c.handle, &wait), "no picture is free");
  painter.eye(int(which), c.image[index].image, c.width, c.height);
  const auto release = of_type<XrSwapchainImageReleaseInfo>(XR_TYPE_SWAPCHAIN_IMAGE_RELEASE_INFO);
  check(xrReleaseSwapchainImage(c.handle, &release), "a picture is not taken");
}

XrTime OpenXrSession::now(int64_t& monotonic) const {
  monotonic = monotonic_ns();
  if (!to_time_) return monotonic + ahead_ns_;  // when the next frame is seen: the one time that is known
  const timespec ts{monotonic / 1'000'000'000, monotonic % 1'000'000'000};
  XrTime t = 0;
  check(to_time_(instance_, &ts, &t), "its clock is not known");
  return t;
}

bool OpenXrSession::pressed(XrAction action, size_t hand) const {
  auto get = of_type<XrActionStateGetInfo>(XR_TYPE_ACTION_STATE_GET_INFO);
  get.action = action, get.subactionPath = hand_[hand];
  auto state = of_type<XrActionStateBoolean>(XR_TYPE_ACTION_STATE_BOOLEAN);
  check(xrGetActionStateBoolean(session_, &get, &state), "a button is not known");
  return state.isActive && state.currentState;
}

bool OpenXrSession::read(HandsReading& reading) {
  reading = {};
  if (!focused_ || lost_) return false;
  const XrActiveActionSet set{actions_, XR_NULL_PATH};
  auto sync = of_type<XrActionsSyncInfo>(XR_TYPE_ACTIONS_SYNC_INFO);
  sync.countActiveActionSets = 1, sync.activeActionSets = &set;
  const XrResult synced = xrSyncActions(session_, &sync);
  check(synced, "its hands are not known");
  if (synced == XR_SESSION_NOT_FOCUSED) return false;
  const XrTime at = now(reading.at_ns);
  if (at <= 0) return false;
  for (size_t h = 0; h < 2; ++h) {
    HandReading& r = reading.hand[h];
    auto get = of_type<XrActionStateGetInfo>(XR_TYPE_ACTION_STATE_GET_INFO);
    get.action = aim_, get.subactionPath = hand_[h];
    auto pose = of_type<XrActionStatePose>(XR_TYPE_ACTION_STATE_POSE);
    check(xrGetActionStatePose(session_, &get, &pose), "a hand is not known");
    if (pose.isActive) {
      auto where = of_type<XrSpaceLocation>(XR_TYPE_SPACE_LOCATION);
      check(xrLocateSpace(aim_space_[h], room_, at, &where), "a hand is nowhere");
      r.controller = known(where.locationFlags);
      r.aim = pose_of(where.pose);
      r.press = pressed(press_, h), r.clutch = pressed(clutch_, h), r.place = pressed(place_, h);
    }
    if (tracker_[h] == XR_NULL_HANDLE) continue;
    std::array<XrHandJointLocationEXT, XR_HAND_JOINT_COUNT_EXT> joint{};
    auto info = of_type<XrHandJointsLocateInfoEXT>(XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT);
    info.baseSpace = room_, info.time = at;
    auto joints = of_type<XrHandJointLocationsEXT>(XR_TYPE_HAND_JOINT_LOCATIONS_EXT);
    joints.jointCount = uint32_t(joint.size()), joints.jointLocations = joint.data();
    check(locate_joints_(tracker_[h], &info, &joints), "a hand is nowhere");
    const XrHandJointLocationEXT &f = joint[XR_HAND_JOINT_INDEX_TIP_EXT], &t = joint[XR_HAND_JOINT_THUMB_TIP_EXT];
    r.fingers = joints.isActive && known(f.locationFlags) && known(t.locationFlags);
    r.forefinger = pose_of(f.pose), r.thumb = pose_of(t.pose);
  }
  return true;
}

}  // namespace
}  // namespace limberg

extern "C" limberg::HeadsetSession* limberg_headset_session(const limberg::MakeContext& make_context) {
  return new limberg::OpenXrSession(make_context);
}

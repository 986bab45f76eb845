#include "render/headset.h"

#include <cmath>

#include "render/gl_context.h"

#ifdef LIMBERG_OPENXR
#include <openxr/openxr.h>

#include <cstring>
#include <vector>
#endif

namespace limberg {

View eye_view(const Vec3f& at_mm, const Eigen::Quaternionf& turned, const EyeAngles& a, float n, float f) {
  View v;
  v.eye_mm = at_mm;
  const Eigen::Matrix3f back = turned.normalized().toRotationMatrix().transpose();
  v.to_eye.block<3, 3>(0, 0) = back;
  v.to_eye.block<3, 1>(0, 3) = -(back * at_mm);
  const float l = std::tan(a.left), r = std::tan(a.right), u = std::tan(a.up), d = std::tan(a.down);
  v.projection.setZero();
  v.projection(0, 0) = 2 / (r - l), v.projection(0, 2) = (r + l) / (r - l);
  v.projection(1, 1) = 2 / (u - d), v.projection(1, 2) = (u + d) / (u - d);
  v.projection(2, 2) = -(f + n) / (f - n), v.projection(2, 3) = -2 * f * n / (f - n);
  v.projection(3, 2) = -1;
  return v;
}

#ifdef LIMBERG_OPENXR

namespace {

struct Instance {
  XrInstance handle = XR_NULL_HANDLE;
  ~Instance() {
    if (handle != XR_NULL_HANDLE) xrDestroyInstance(handle);
  }
};

template <class T>
T of_type(XrStructureType type) {
  T t{};
  t.type = type;
  return t;
}

void check(XrResult result, const char* what) {
  if (XR_FAILED(result))
    throw RenderUnavailable(std::string("no headset: ") + what + " (OpenXR error " + std::to_string(int(result)) + ")");
}

}  // namespace

Headset find_headset() {
  auto create = of_type<XrInstanceCreateInfo>(XR_TYPE_INSTANCE_CREATE_INFO);
  std::strncpy(create.applicationInfo.applicationName, "Limberg", XR_MAX_APPLICATION_NAME_SIZE - 1);
  create.applicationInfo.applicationVersion = 1;
  create.applicationInfo.apiVersion = XR_CURRENT_API_VERSION;
  Instance instance;
  check(xrCreateInstance(&create, &instance.handle), "no OpenXR runtime answers; XR_RUNTIME_JSON names its manifest");
  auto runtime = of_type<XrInstanceProperties>(XR_TYPE_INSTANCE_PROPERTIES);
  check(xrGetInstanceProperties(instance.handle, &runtime), "the runtime does not say what it is");
  auto wanted = of_type<XrSystemGetInfo>(XR_TYPE_SYSTEM_GET_INFO);
  wanted.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
  XrSystemId system = XR_NULL_SYSTEM_ID;
  check(xrGetSystem(instance.handle, &wanted, &system), "the runtime has no head-mounted display");
  auto properties = of_type<XrSystemProperties>(XR_TYPE_SYSTEM_PROPERTIES);
  check(xrGetSystemProperties(instance.handle, system, &properties), "the headset does not say what it is");
  uint32_t count = 0;
  const XrViewConfigurationType stereo = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
  check(xrEnumerateViewConfigurationViews(instance.handle, system, stereo, 0, &count, nullptr),
        "the headset has no stereo views");
  std::vector<XrViewConfigurationView> views(count, of_type<XrViewConfigurationView>(XR_TYPE_VIEW_CONFIGURATION_VIEW));
  check(xrEnumerateViewConfigurationViews(instance.handle, system, stereo, count, &count, views.data()),
        "the headset does not describe its views");
  Headset h;
  h.runtime = runtime.runtimeName, h.system = properties.systemName, h.views = int(count);
  if (count > 0) h.width = int(views[0].recommendedImageRectWidth), h.height = int(views[0].recommendedImageRectHeight);
  return h;
}

#else

Headset find_headset() {
  throw RenderUnavailable("no headset: this program was built without OpenXR (LIMBERG_OPENXR=OFF)");
}

#endif

}  // namespace limberg

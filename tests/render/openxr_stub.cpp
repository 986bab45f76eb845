// A runtime of OpenXR with one headset and no frames: enough
// for the loader to accept, and for tests to ask what is there.
#include <openxr/openxr.h>

#include <cstring>

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

XrResult create_instance(const XrInstanceCreateInfo*, XrInstance* instance) {
  *instance = reinterpret_cast<XrInstance>(1);
  return XR_SUCCESS;
}
XrResult destroy_instance(XrInstance) { return XR_SUCCESS; }
XrResult extensions(const char*, uint32_t, uint32_t* count, XrExtensionProperties*) {
  *count = 0;
  return XR_SUCCESS;
}
XrResult instance_properties(XrInstance, XrInstanceProperties* p) {
  p->runtimeVersion = XR_MAKE_VERSION(1, 0, 0);
  std::strcpy(p->runtimeName, "runtime of the tests");
  return XR_SUCCESS;
}
XrResult system_of(XrInstance, const XrSystemGetInfo* wanted, XrSystemId* id) {
  if (wanted->formFactor != XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY) return XR_ERROR_FORM_FACTOR_UNSUPPORTED;
  *id = 7;
  return XR_SUCCESS;
}
XrResult system_properties(XrInstance, XrSystemId id, XrSystemProperties* p) {
  if (id != 7) return XR_ERROR_SYSTEM_INVALID;
  std::strcpy(p->systemName, "headset of the tests");
  return XR_SUCCESS;
}
XrResult views(XrInstance, XrSystemId, XrViewConfigurationType type, uint32_t room, uint32_t* count,
               XrViewConfigurationView* out) {
  if (type != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO) return XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED;
  *count = 2;
  for (uint32_t i = 0; i < room && i < 2; ++i)
    out[i].recommendedImageRectWidth = 1440, out[i].recommendedImageRectHeight = 1600;
  return XR_SUCCESS;
}

XrResult address(XrInstance, const char* name, PFN_xrVoidFunction* function) {
  const auto is = [&](const char* other) { return std::strcmp(name, other) == 0; };
  *function = is("xrCreateInstance")                         ? reinterpret_cast<PFN_xrVoidFunction>(create_instance)
              : is("xrDestroyInstance")                      ? reinterpret_cast<PFN_xrVoidFunction>(destroy_instance)
              : is("xrEnumerateInstanceExtensionProperties") ? reinterpret_cast<PFN_xrVoidFunction>(extensions)
              : is("xrGetInstanceProperties")                ? reinterpret_cast<PFN_xrVoidFunction>(instance_properties)
              : is("xrGetSystem")                            ? reinterpret_cast<PFN_xrVoidFunction>(system_of)
              : is("xrGetSystemProperties")                  ? reinterpret_cast<PFN_xrVoidFunction>(system_properties)
              : is("xrEnumerateViewConfigurationViews")      ? reinterpret_cast<PFN_xrVoidFunction>(views)
              : is("xrGetInstanceProcAddr")                  ? reinterpret_cast<PFN_xrVoidFunction>(address)
                                                             : nullptr;
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

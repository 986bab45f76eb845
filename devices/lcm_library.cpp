#include "devices/lcm_library.h"

#include "sim/base/error.h"
#include "sim/base/part.h"

namespace limberg {

std::unique_ptr<LcmLibrary> open_lcm(const std::string& url) {
  const LoadedPart part = load_part("lcm", "limberg_lcm", "LCM (Debian: liblcm1)");
  if (!part.entry) throw InputError("", 0, "LCM address \"" + url + "\" needs LCM's library: " + part.why);
  const auto make = reinterpret_cast<LcmLibrary* (*)(const std::string&)>(part.entry);
  std::unique_ptr<LcmLibrary> lcm(make(url));
  if (!lcm)
    throw InputError(
        "", 0,
        "LCM address \"" + url +
            "\" cannot be opened; expected a multicast route, for instance after: ip route add 224.0.0.0/4 dev lo");
  return lcm;
}

}  // namespace limberg

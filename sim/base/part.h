#pragma once
// Parts of the program that few sessions need, each a small library of its own: opened when it is first needed and
// kept. A session without it neither maps nor starts what the part links.
//
//   limberg-bullet.so   bones that a hand holds (Bullet)     limberg-glfw.so   a window (GLFW, X11)
//   limberg-lcm.so      LCM's own library (GLib)           limberg-gdcm.so   compressed DICOM slices (GDCM)
//   limberg-openxr.so   a headset (OpenXR's loader)
//
// A part is an implementation of a class of virtual functions, made by one function with C linkage. It includes the
// program's headers and links none of its libraries.
//
// Parts lie in parts/ (a build) or lib/limberg (an installation) of the folder of the program, of the shared library
// that holds this code (Python's module), or of one of the four folders above these (as long as only their owner may
// write to them), and nowhere else: neither the working folder nor LD_LIBRARY_PATH is asked.
#include <string>
#include <vector>

namespace limberg {

struct LoadedPart {
  void* entry = nullptr;  // null: it cannot be had
  std::string why;        // then: what is missing, and what was expected
};

/// The folders of the running program and of the library that holds this code, and four above each: nearest first.
std::vector<std::string> folders_above_code();

/// `name`: "bullet"; `entry`: the function that makes it; `needs`: "Bullet (Debian: libbullet-dev)".
LoadedPart load_part(const std::string& name, const char* entry, const std::string& needs);

}  // namespace limberg

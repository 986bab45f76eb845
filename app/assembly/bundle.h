#pragma once
// A scene with the files it needs, inside a recording: so that the recording alone reproduces the run.
#include <memory>
#include <string>
#include <vector>

#include "app/scene/scene.h"
#include "calibration/calibration.h"
#include "devices/recording.h"

namespace limberg {

/// The scene's text, the files that it names, its library of tissues if it has one, and the calibration, as blobs.
/// InputError when a file lies at a path that cannot be put beside the scene elsewhere (absolute, or more than eight
/// folders up).
std::vector<Blob> bundle(const Scene& scene, const Calibration& calibration);

/// A scene taken out of a recording. Its mesh lies in a temporary folder
/// that goes away with `files`: keep that until the body is built.
struct Unbundled {
  Scene scene;
  std::shared_ptr<void> files;
};

/// The scene of a recording. `recording_file` names the file in messages.
/// InputError when it holds no whole scene, or one that cannot be read.
Unbundled unbundle_scene(const Recording& recording, const std::string& recording_file);
/// The calibration of a recording; the identity when it holds none.
Calibration unbundle_calibration(const Recording& recording, const std::string& recording_file);

}  // namespace limberg

#pragma once
// The acts that undo and redo go through, as the window has heard of them: what each was, when, and how the patient
// looked after it. What is undone stays in the list until another act takes its place.
#include <cstddef>
#include <string>
#include <vector>

#include "app/session/notice.h"
#include "render/image.h"

namespace limberg {

class ActHistory {
 public:
  struct Entry {
    uint64_t number = 0;  // of all that ever were: names its picture
    std::string text;
    double t_s = 0;
    int stroke = 0;  // of an incision in pieces
    Image picture;   // small; empty until it was taken
    int taken = 0;   // how often; the last time at rest
  };

  void hear(const Notice& notice);
  const std::vector<Entry>& entries() const { return entries_; }
  /// So many of the entries are done, the first; the others are undone.
  size_t standing() const { return standing_; }
  /// The patient before the first entry: as the scene is, or after the act that the list forgot last.
  const Entry& start() const { return start_; }
  /// The entry that the patient shows now, if its picture is still wanted: a first one, and one at rest. Null: none.
  Entry* unseen(bool at_rest);

 private:
  Entry start_;
  std::vector<Entry> entries_;
  size_t standing_ = 0;
  uint64_t number_ = 0;
};

/// A part of an image from (x0, y0) to (x1, y1), made so small that it fits. Each pixel is a mean.
Image thumbnail(const Image& image, int x0, int y0, int x1, int y1, int width, int height);

}  // namespace limberg

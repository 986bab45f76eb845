#pragma once
// What is written over a finished picture: captions and the legend of a colour map.
#include <string>

#include "render/colour_map.h"
#include "render/image.h"
#include "render/text.h"

namespace limberg {

struct Legend {
  std::string title;  // what is shown
  std::string unit;   // of the numbers on the ticks
  double min = 0, max = 1;
  ColourScale scale = ColourScale::magnitude;
  bool clipped_above = false, clipped_below = false;  // values lie beyond the ends: marked with a triangle
  char decimal = '.';                                 // between a number and its fraction
};

/// Title (bold) and caption in the top left corner. Sizes follow the height of the image.
void draw_caption(Image& image, const TextPainter& text, const std::string& title, const std::string& caption);

/// A vertical bar of the colour map with ticks, on a panel at the right edge.
void draw_legend(Image& image, const TextPainter& text, const Legend& legend);

/// A round step (1, 2 or 5 times a power of ten) that parts `range` into at most `most` intervals.
double round_step(double range, int most);

/// A number as short as it can be at the precision of `step`.
std::string tick_label(double value, double step);

}  // namespace limberg

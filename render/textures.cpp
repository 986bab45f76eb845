#include "render/textures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace limberg {

namespace {

uint32_t mix_bits(uint32_t h) {
  h ^= h >> 16, h *= 0x7feb352du, h ^= h >> 15, h *= 0x846ca68bu, h ^= h >> 16;
  return h;
}

// A random number in [0, 1) that belongs to a cell of a torus of `period` cells.
float cell_value(int x, int y, int period, uint32_t seed) {
  const uint32_t i = uint32_t((x % period + period) % period), j = uint32_t((y % period + period) % period);
  return float(mix_bits(i + 0x9e3779b9u * j + 0x85ebca6bu * seed) >> 8) * (1.0f / 16777216.0f);
}

// Value noise on the torus [0,1)^2 with `period` cells.
float noise(float u, float v, int period, uint32_t seed) {
  const float x = u * float(period), y = v * float(period);
  const int i = int(std::floor(x)), j = int(std::floor(y));
  float fx = x - float(i), fy = y - float(j);
  fx = fx * fx * (3 - 2 * fx), fy = fy * fy * (3 - 2 * fy);
  const float a = cell_value(i, j, period, seed), b = cell_value(i + 1, j, period, seed),
              c = cell_value(i, j + 1, period, seed), d = cell_value(i + 1, j + 1, period, seed);
  return a + fx * (b - a) + fy * (c - a) + fx * fy * (a - b - c + d);
}

float fractal(float u, float v, int period, int octaves, uint32_t seed) {
  float sum = 0, weight = 0.5f, total = 0;
  for (int o = 0; o < octaves; ++o, period *= 2, weight *= 0.5f) {
    sum += weight * noise(u, v, period, seed + uint32_t(o));
    total += weight;
  }
  return sum / total;
}

// Distances to the nearest and second nearest of one random point per cell, in cells.
std::array<float, 2> worley(float u, float v, int period, uint32_t seed) {
  const float x = u * float(period), y = v * float(period);
  const int i = int(std::floor(x)), j = int(std::floor(y));
  float first = 9, second = 9;
  for (int b = j - 1; b <= j + 1; ++b)
    for (int a = i - 1; a <= i + 1; ++a) {
      const float dx = float(a) + cell_value(a, b, period, seed) - x,
                  dy = float(b) + cell_value(a, b, period, seed + 77) - y;
      const float d = std::sqrt(dx * dx + dy * dy);
      if (d < first)
        second = first, first = d;
      else if (d < second)
        second = d;
    }
  return {first, second};
}

uint8_t byte(float v) { return uint8_t(std::lround(std::clamp(v, 0.0f, 255.0f))); }

template <class F>
Texels fill(int w, int h, F&& f) {
  Texels t{w, h, std::vector<uint8_t>(4 * size_t(w) * size_t(h))};
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const std::array<uint8_t, 4> c = f((float(x) + 0.5f) / float(w), (float(y) + 0.5f) / float(h));
      std::copy(c.begin(), c.end(), t.rgba.begin() + 4 * (std::ptrdiff_t(y) * w + x));
    }
  return t;
}

}  // namespace

Texels skin_texture(int size) {
  return fill(size, size, [](float u, float v) -> std::array<uint8_t, 4> {
    const float blotch = fractal(u, v, 5, 3, 1) - 0.5f;    // flush, some 10 mm across
    const float mottle = fractal(u, v, 40, 3, 11) - 0.5f;  // a millimetre or two
    // Pores are a little darker than what is between them; here and there lies a freckle.
    const float pore = std::clamp(1.25f - 4.0f * worley(u, v, 74, 23)[0], 0.0f, 1.0f);
    const float freckle = fractal(u, v, 44, 2, 31);
    const float brown = std::clamp(9 * (freckle - 0.83f), 0.0f, 1.0f);
    const float light = 1 + 0.08f * mottle - 0.075f * pore;
    return {byte(230 * light + 5 * blotch - 18 * brown), byte(187 * light - 30 * blotch - 5 * mottle - 24 * brown),
            byte(166 * light - 27 * blotch - 5 * mottle - 26 * brown), 255};
  });
}

Texels grid_texture(int size) {
  // Coverage of a line `width` mm wide, drawn with soft edges so that mipmaps keep its weight.
  const auto line = [](float mm, float period, float width) {
    const float d = std::abs(mm - period * std::round(mm / period));
    return std::clamp((0.5f * width - d) / 0.02f + 0.5f, 0.0f, 1.0f);
  };
  return fill(size, size, [&](float u, float v) -> std::array<uint8_t, 4> {
    const float x = 10 * u, y = 10 * v;
    const float bold = std::max(line(x, 10, 0.30f), line(y, 10, 0.30f));
    const float fine = std::max(line(x, 1, 0.10f), line(y, 1, 0.10f));
    return {byte(255 * fine), byte(255 * bold), 0, 255};
  });
}

namespace {

// Fat lies in lobules of several sizes that press against each other: the upper hull of round domes, one about a point
// of each cell, softened where two meet. Height in [0, 1], and a number of the lobule.
std::array<float, 2> lobules(float u, float v, int period, uint32_t seed) {
  const float x = u * float(period), y = v * float(period);
  const int i = int(std::floor(x)), j = int(std::floor(y));
  float highest = -9, sum = 0, number = 0;
  for (int b = j - 1; b <= j + 1; ++b)
    for (int a = i - 1; a <= i + 1; ++a) {
      const float dx = float(a) + 0.15f + 0.7f * cell_value(a, b, period, seed) - x,
                  dy = float(b) + 0.15f + 0.7f * cell_value(a, b, period, seed + 77) - y;
      const float size = 0.75f + 0.45f * cell_value(a, b, period, seed + 154);
      const float dome = 1 - (dx * dx + dy * dy) / (size * size);
      if (dome > highest) highest = dome, number = cell_value(a, b, period, seed + 231);
      sum += std::exp(14 * std::max(dome, -2.0f));
    }
  return {std::clamp((std::log(sum) / 14 - 0.55f) / 0.47f, 0.0f, 1.0f), number};
}

}  // namespace

Texels detail_texture(int size) {
  return fill(size, size, [](float u, float v) -> std::array<uint8_t, 4> {
    const auto pore = worley(u, v, 44, 3);
    const float pores = 0.55f * std::min(1.0f, 2.2f * (pore[1] - pore[0])) + 0.45f * fractal(u, v, 24, 4, 5);
    const float bent = 0.03f * fractal(u, v, 12, 2, 61), askew = 0.03f * fractal(u, v, 12, 2, 71);
    const auto large = lobules(u + bent, v + askew, 9, 9), small = lobules(u + askew, v + bent, 23, 19);
    return {byte(255 * pores), byte(255 * (0.76f * large[0] + 0.24f * small[0])), byte(255 * fractal(u, v, 8, 4, 17)),
            byte(255 * large[1])};
  });
}

Texels slope_texture(const Texels& detail) {
  Texels t{detail.width, detail.height, std::vector<uint8_t>(detail.rgba.size())};
  const int w = t.width, h = t.height;
  const auto height = [&](int x, int y, size_t c) {
    return float(detail.rgba[4 * (size_t((y + h) % h) * size_t(w) + size_t((x + w) % w)) + c]);
  };
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      for (size_t c = 0; c < 2; ++c) {
        uint8_t* out = &t.rgba[4 * (size_t(y) * size_t(w) + size_t(x)) + 2 * c];
        out[0] = byte(127.5f + 0.5f * kSlopeGain * (height(x + 1, y, c) - height(x - 1, y, c)));
        out[1] = byte(127.5f + 0.5f * kSlopeGain * (height(x, y + 1, c) - height(x, y - 1, c)));
      }
  return t;
}

Texels layer_texture(const std::vector<Layer>& layers, double range_mm, int size) {
  using C = std::array<float, 3>;
  const C epidermis{170, 98, 80}, dermis{248, 216, 204}, dermis_low{240, 196, 180}, fat{247, 212, 128},
      fat_low{240, 192, 104}, muscle{158, 52, 44}, deep{178, 92, 78};
  const auto mix = [](const C& a, const C& b, float t) {
    t = std::clamp(t, 0.0f, 1.0f);
    return C{a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
  };
  // The layers by name where the name says it, otherwise by order.
  const auto has = [](const std::string& name, const char* word) { return name.find(word) != std::string::npos; };
  const auto kind = [&](size_t i) {  // 0 skin, 1 fat, 2 muscle
    const std::string& name = layers[i].name;
    if (has(name, "skin") || has(name, "dermis")) return 0;
    if (has(name, "fat") || has(name, "subcut")) return 1;
    if (has(name, "muscle") || has(name, "smas") || has(name, "fascia") || has(name, "galea")) return 2;
    return int(std::min(i, size_t(2)));
  };
  return fill(size, 1, [&](float u, float) -> std::array<uint8_t, 4> {
    const float depth = u * float(range_mm);
    C c = deep;
    float top = 0;
    for (size_t i = 0; i < layers.size(); ++i) {
      const float thick = float(layers[i].thickness_mm), bottom = i + 1 == layers.size() ? 1e9f : top + thick;
      if (depth <= bottom) {
        const float t = std::clamp((depth - top) / std::max(thick, 0.1f), 0.0f, 1.0f);
        switch (kind(i)) {
          case 0:
            c = mix(dermis, dermis_low, t);
            break;
          case 1:
            c = mix(fat, fat_low, t);
            break;
          default:
            c = mix(muscle, deep, 0.3f * t);
            break;
        }
        if (kind(i) == 1 && t > 0.85f) c = mix(c, deep, (t - 0.85f) / 0.15f * 0.6f);
        break;
      }
      top = bottom;
    }
    if (layers.empty()) c = mix(dermis, fat, (depth - 1.2f) / 0.4f);
    c = mix(epidermis, c, (depth - 0.10f) / 0.08f);
    return {byte(c[0]), byte(c[1]), byte(c[2]), 255};
  });
}

Texels scale_texture(ColourScale scale) {
  Texels t{256, 1, {}};
  for (int i = 0; i < 256; ++i) {
    const Rgb8 c = colour_of(scale, i / 255.0);
    t.rgba.insert(t.rgba.end(), {c.r, c.g, c.b, 255});
  }
  return t;
}

}  // namespace limberg

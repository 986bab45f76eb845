#include "app/report/viewer.h"

#include <fmt/format.h>
#include <zlib.h>

#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "app/report/html.h"
#include "app/report/report_names.h"
#include "app/report/viewer_texts.h"
#include "app/result/json_nesting.h"
#include "app/result/read_result.h"
#include "render/textures.h"
#include "sim/base/error.h"
#include "sim/base/hash.h"
#include "sim/base/whole_file.h"
#include "sim/measure/table.h"

namespace limberg {

namespace {

using ModelJson = nlohmann::json;

constexpr size_t kMostModel = size_t(256) << 20;

[[noreturn]] void no_model(const std::string& file, const std::string& why) {
  throw InputError(file, 0, why + "; expected the model that a run has left");
}

std::string gzip(const std::string& bytes) {
  z_stream z{};
  if (deflateInit2(&z, 6, Z_DEFLATED, 15 + 16, 9, Z_DEFAULT_STRATEGY) != Z_OK) throw std::runtime_error("zlib");
  std::string out(deflateBound(&z, uLong(bytes.size())), '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data())), z.avail_in = uInt(bytes.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data()), z.avail_out = uInt(out.size());
  const int done = deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  if (done != Z_STREAM_END) throw std::runtime_error("zlib");
  return out;
}

/// The first bytes of all rows, then the second ones, and so on, each less the one before it.
void reorder(char* at, size_t length, size_t row) {
  const size_t rows = length / row;
  const std::string was(at, rows * row);
  for (size_t k = 0, to = 0; k < row; ++k) {
    unsigned char before = 0;
    for (size_t i = 0; i < rows; ++i) {
      const auto now = static_cast<unsigned char>(was[i * row + k]);
      at[to++] = char(static_cast<unsigned char>(now - before)), before = now;
    }
  }
}

std::string colours(ColourScale scale) {
  const Texels t = scale_texture(scale);
  std::string s;
  for (size_t i = 0; i + 3 < t.rgba.size(); i += 4)
    s += fmt::format("{:02x}{:02x}{:02x}", t.rgba[i], t.rgba[i + 1], t.rgba[i + 2]);
  return s;
}

std::string script(const std::string& attributes, const std::string& text) {
  return "<script" + attributes + ">" + text + "</script>\n";
}

}  // namespace

bool viewer_is_built() { return three_js_text[0] != 0; }

std::string packed_model(const std::string& glb, const std::string& file) {
  const auto word = [&](size_t at) {
    uint32_t v = 0;
    std::memcpy(&v, glb.data() + at, 4);
    return size_t(v);
  };
  if (glb.size() < 28 || glb.compare(0, 4, "glTF") != 0 || glb.size() > kMostModel) no_model(file, "is no binary glTF");
  const size_t json_length = word(12), bin = 28 + json_length;
  if (json_length > glb.size() - 28 || word(bin - 8) != glb.size() - bin) no_model(file, "is cut short");
  const std::string text = glb.substr(20, json_length);
  if (json_nesting(text) > 32) no_model(file, "is nested too deeply");
  const ModelJson j = ModelJson::parse(text, nullptr, false);
  using result_json::member;
  if (!member(member(member(j, "asset"), "extras"), "limberg_page_model").is_number())
    no_model(file, "is not the model of a page");
  std::string packed = glb;
  size_t end = 0;
  for (const ModelJson& v : member(j, "bufferViews")) {
    const auto whole = [](const ModelJson& n, size_t otherwise) {
      return n.is_number_unsigned() ? n.get<size_t>() : otherwise;
    };
    const size_t at = whole(member(v, "byteOffset"), 0), length = whole(member(v, "byteLength"), 0),
                 row = whole(member(v, "byteStride"), whole(member(member(v, "extras"), "row"), 1));
    // One after another: none is reordered twice.
    if (at < end || at > glb.size() - bin || length > glb.size() - bin - at || row < 1 || row > 252)
      no_model(file, "has a buffer view that lies elsewhere");
    end = at + length;
    reorder(packed.data() + bin + at, length, row);
  }
  return gzip(packed);
}

Viewer viewer(const std::vector<ViewedOperation>& operations) {
  Viewer out;
  if (!viewer_is_built()) return out;
  std::vector<std::pair<std::string, std::string>> models;  // name, base64
  Hash64 hash;
  for (const ViewedOperation& o : operations) {
    const std::string file = (std::filesystem::path(o.dir) / report_names::model).string();
    try {
      models.emplace_back(o.name, html::base64(packed_model(read_whole_file(file, kMostModel, "a model"), file)));
    } catch (const InputError&) {
      continue;  // none, or damaged: the page is complete without
    }
    hash.add(models.back().second);
  }
  if (models.empty()) return out;
  out.nonce = fmt::format("{:016x}", hash.value());
  const std::string allowed = " nonce=\"" + out.nonce + "\"";
  ModelJson setup{
      {"warn_N", kSutureForce_N.warn},
      {"bad_N", kSutureForce_N.bad},
      {"colours", {{"magnitude", colours(ColourScale::magnitude)}, {"signed", colours(ColourScale::signed_value)}}}};
  std::string tags =
      "<style>" + std::string(viewer_css_text) +
      "</style>\n<section id=\"viewer\" hidden=\"hidden\">\n<h2>The operation, to turn and to play</h2>\n</section>\n"
      "<noscript><p class=\"note\">With scripts, this page also shows the patient to be turned and "
      "played. The pictures show the same operation.</p></noscript>\n";
  for (const auto& [name, model] : models)
    tags += script(" type=\"application/x-limberg-model\" data-model=\"" + html::escape(name) + "\"", model);
  tags += script(" type=\"application/json\" id=\"viewer-setup\"", setup.dump());
  const auto run = [&](const std::string& text) { tags += script(allowed, "//<![CDATA[\n" + text + "\n//]]>"); };
  run("/* three.js r111, copyright 2010-2019 three.js authors, MIT licence: https://threejs.org/license */\n" +
      std::string(three_js_text));
  run(viewer_js_text);
  out.section = html::Markup::of_tags(std::move(tags));
  return out;
}

}  // namespace limberg

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

/// What viewer.js says.
constexpr const char* kViewerTexts[] = {
    english(
        "The patient in three dimensions. Arrow keys turn, with Shift they move; plus and minus bring it nearer and "
        "farther; Home goes back to the first view; Page Up and Page Down go from act to act; the space bar plays."),
    english("Time of the operation"),
    english("Stages"),
    english("Colours"),
    english("As it looks"),
    english("Face"),
    english("see through"),
    english("solid"),
    english("hidden"),
    english("Forces of the stitches"),
    english("First view"),
    english(
        "Drag to turn, with two fingers or the right button to move, pinch or use the wheel (after a click) to come "
        "nearer. Keys: arrows, + and −, Home, Page Up and Page Down, space."),
    english("Before the first act"),
    english("act {} of {}"),
    english("Pause"),
    english("Play"),
    english("This browser cannot show the model ({}); the pictures show the operation.")};

/// Names and acts in a model that was found whole.
void tell_texts_of(const std::string& glb, const std::function<void(const std::string&)>& tell) {
  using result_json::member;
  uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, 4);
  const ModelJson j = ModelJson::parse(glb.substr(20, length), nullptr, false);
  const ModelJson& told = member(member(j, "asset"), "extras");
  for (const auto& [list, keys] : {std::pair("acts", std::vector<const char*>{"words"}),
                                   std::pair("fields", std::vector<const char*>{"name", "title", "unit"})})
    for (const ModelJson& entry : member(told, list))
      for (const char* key : keys)
        if (const ModelJson& text = member(entry, key); text.is_string()) tell(text.get<std::string>());
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

Viewer viewer(const std::vector<ViewedOperation>& operations, const Words& w) {
  Viewer out;
  if (!viewer_is_built()) return out;
  std::vector<std::pair<std::string, std::string>> models;  // name, base64
  ModelJson words = ModelJson::object();  // of the viewer and of the models, where they are not English
  const auto tell = [&](const std::string& text) {
    if (const std::string s = w.said(text); w.language() != "en" && s != text) words[text] = s;
  };
  if (w.language() != "en")
    for (const char* text : kViewerTexts) words[text] = w(text);  // with their places, which the page fills
  Hash64 hash;
  for (const ViewedOperation& o : operations) {
    const std::string file = (std::filesystem::path(o.dir) / report_names::model).string();
    try {
      const std::string glb = read_whole_file(file, kMostModel, "a model");
      models.emplace_back(o.name, html::base64(packed_model(glb, file)));
      if (w.language() != "en") tell_texts_of(glb, tell);
    } catch (const InputError&) {
      continue;  // none, or damaged: the page is complete without
    }
    hash.add(models.back().second);
  }
  if (models.empty()) return out;
  out.nonce = fmt::format("{:016x}", hash.value());
  const std::string allowed = " nonce=\"" + out.nonce + "\"";
  ModelJson setup{
      {"words", std::move(words)},
      {"decimal", std::string(1, w.decimal())},
      {"warn_N", kSutureForce_N.warn},
      {"bad_N", kSutureForce_N.bad},
      {"colours", {{"magnitude", colours(ColourScale::magnitude)}, {"signed", colours(ColourScale::signed_value)}}}};
  std::string tags =
      "<style>" + std::string(viewer_css_text) + "</style>\n<section id=\"viewer\" hidden=\"hidden\">\n<h2>" +
      html::escape(w("The operation, to turn and to play")) + "</h2>\n</section>\n<noscript><p class=\"note\">" +
      html::escape(
          w("With scripts, this page also shows the patient to be turned and played. The pictures show the same "
            "operation.")) +
      "</p></noscript>\n";
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

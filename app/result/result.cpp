#include "app/result/result.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "app/program/version.h"
#include "app/result/json_nesting.h"
#include "app/result/output.h"
#include "app/result/run_result.h"
#include "sim/base/error.h"

namespace limberg {

using Json = nlohmann::ordered_json;

struct Result::Impl {
  Json json;

  /// What is not there yet is made. Not by indexing what is null: of an object for which there was no memory the
  /// library keeps a half-made one, whose end is a crash.
  Json& at(std::string_view path) {
    std::vector<std::string> names;
    for (Json::json_pointer p{std::string(path)}; !p.empty(); p.pop_back()) names.push_back(p.back());
    Json* node = &json;
    for (auto name = names.rbegin(); name != names.rend(); ++name) {
      const bool is_number = !name->empty() && name->find_first_not_of("0123456789") == std::string::npos;
      if (node->is_null()) *node = is_number ? Json::array() : Json::object();
      node = node->is_array() ? &(*node)[size_t(std::stoul(*name))] : &(*node)[*name];
    }
    return *node;
  }
};

namespace {

std::string cpu_name() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("model name")) {
      const size_t colon = line.find(':');
      if (colon != std::string::npos && colon + 2 <= line.size()) return line.substr(colon + 2);
    }
  return "unknown";
}

}  // namespace

Result::Result(const std::string& command, const std::string& scene) : impl_(std::make_unique<Impl>()) {
  write_fields(*this, "",
               ResultOrigin{{version(), commit()}, command, scene, {cpu_name(), sysconf(_SC_NPROCESSORS_ONLN)}, true});
}
Result::~Result() = default;
Result::Result(Result&&) noexcept = default;

void Result::set(std::string_view path, double v) { impl_->at(path) = v; }
void Result::set(std::string_view path, int64_t v) { impl_->at(path) = v; }
void Result::set(std::string_view path, bool v) { impl_->at(path) = v; }
void Result::set(std::string_view path, const std::string& v) { impl_->at(path) = v; }
void Result::set_empty_list(std::string_view path) { impl_->at(path) = Json::array(); }

int Result::entries(std::string_view path) const {
  const Json::json_pointer at{std::string(path)};
  return impl_->json.contains(at) && impl_->json.at(at).is_array() ? int(impl_->json.at(at).size()) : 0;
}

void Result::set(std::string_view path, std::span<const float> v) {
  Json list = Json::array();
  for (const float x : v) {
    // The shortest decimals of the float, not of the double that it becomes.
    const std::string text = fmt::format("{:.6g}", double(x));
    list.push_back(std::isfinite(x) ? Json(std::stod(text)) : Json());
  }
  impl_->at(path) = std::move(list);
}

void Result::take(std::string_view path, const std::string& other_file) {
  const std::string text = read_whole_file(other_file);
  if (json_nesting(text) > 64)  // writing it again would take stack for each level
    throw InputError(other_file, 0, "nests deeper than 64 levels; expected a result.json");
  const Json other = Json::parse(text, nullptr, false);
  if (!other.is_object()) throw InputError(other_file, 0, "is not a JSON object; expected a result.json");
  const Json::json_pointer p{std::string(path)};
  if (other.contains(p)) impl_->at(path) = other.at(p);
}

std::string Result::text() const { return impl_->json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n"; }

void Result::write(const std::string& file) const { write_whole_file(file, text()); }

double peak_memory_mb() {
  rusage u{};
  getrusage(RUSAGE_SELF, &u);
  return double(u.ru_maxrss) / 1024.0;
}

std::string hex(uint64_t v) { return fmt::format("{:016x}", v); }

}  // namespace limberg

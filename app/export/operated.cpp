#include "app/export/operated.h"

#include <nlohmann/json.hpp>

#include "app/result/read_result.h"
#include "sim/base/error.h"

namespace limberg {

OperatedCall operated_call(const std::string& text, const std::string& file) {
  using result_json::member;
  const nlohmann::json r = nlohmann::json::parse(text, nullptr, false);
  if (!r.is_object()) throw InputError(file, 0, "is no result; expected the folder of an `operate`");
  if (result_json::words(member(r, "command")) != "operate")
    throw InputError(
        file, 0, "is not the result of an operate; expected such a folder, or the recording of a session (FILE.lcm)");
  OperatedCall out;
  out.scene_path = result_json::words(member(r, "scene_path"));
  out.cell_mm = result_json::number(member(member(r, "lattice"), "cell_mm")).value_or(0);
  const nlohmann::json& seed = member(member(r, "lattice"), "seed");
  if (seed.is_number_unsigned()) out.seed = seed.get<uint64_t>();
  out.script.name = file;
  const nlohmann::json& lines = member(r, "script");
  if (!lines.is_array() || lines.empty()) throw InputError(file, 0, "holds no script; expected what `operate` writes");
  for (const nlohmann::json& l : lines)
    out.script.lines.push_back(
        {int(out.script.lines.size()) + 1,
         parse_command(result_json::words(l), file + ", line of the script", int(out.script.lines.size()) + 1)});
  return out;
}

}  // namespace limberg

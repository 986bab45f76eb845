// The files of a scene out of a recording: names that anybody may have written lead nowhere but below a folder of ours.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "app/assembly/bundle.h"
#include "sim/base/error.h"
#include "tests/small_block.h"

namespace limberg {
namespace test_bundle {

Recording holding(const std::vector<Blob>& files) {
  Recording rec;
  rec.blobs.push_back({BlobKind::scene, "tiny", test::small_block({})});
  rec.blobs.insert(rec.blobs.end(), files.begin(), files.end());
  return rec;
}

std::string refusal(const std::vector<Blob>& files) {
  try {
    unbundle_scene(holding(files), "r.lcm");
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(Unbundle, FilesInEachOthersWayAreRefused) {
  const Blob a{BlobKind::mesh, "a", "v 0 0 0"}, below_a{BlobKind::mesh, "a/b", "v 0 0 0"};
  const Blob tissues{BlobKind::tissues, "tissues.toml", ""}, below{BlobKind::mesh, "tissues.toml/q", "v 0 0 0"};
  for (const auto& [files, named] : {std::pair{std::vector{a, below_a}, "'a/b'"},
                                     {std::vector{below_a, a}, "'a'"},
                                     {std::vector{tissues, below}, "'tissues.toml/q'"}}) {
    const std::string said = refusal(files);
    EXPECT_NE(said.find(named), std::string::npos) << said;
    EXPECT_NE(said.find("in another one's way; expected paths of files beside each other"), std::string::npos) << said;
  }
}

TEST(Unbundle, NoNameLeadsOutOfTheFolder) {
  const std::string up = "../../../../../../../../../";
  const std::string planted = std::filesystem::temp_directory_path() / fmt::format("planted-{}.obj", getpid());
  for (const std::string& name : {planted, up + planted.substr(1), up + up + "x", "a/../" + up + planted.substr(1)}) {
    const std::string said = refusal({{BlobKind::mesh, name, "v 0 0 0"}});
    EXPECT_NE(said.find("expected a path near its scene"), std::string::npos) << name << ": " << said;
  }
  EXPECT_FALSE(std::filesystem::exists(planted));
  // One beside the scene, and one in a folder above it, are where they may be.
  for (const std::string name : {"skin.obj", "../meshes/skin.obj"})
    EXPECT_EQ(refusal({{BlobKind::mesh, name, "v 0 0 0"}}), "") << name;
}

}  // namespace test_bundle
}  // namespace limberg

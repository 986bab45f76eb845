#pragma once
// The operation in the page: what the browser turns, plays and colours. One page holds the library (Debian's three.js,
// inlined by the build), the viewer (viewer/viewer.js) and the model of each operation (app/export/page_model.h),
// packed. It fetches nothing, and without scripts it is as if it were not there.
//
// Packed: gzip, of the model with the numbers of each buffer view ordered by byte and told as differences, which the
// viewer undoes; what comes out is the file in the folder.
#include <string>
#include <vector>

#include "app/report/markup.h"
#include "app/words/words.h"

namespace limberg {

/// Whether this build has a viewer: three.js was found (LIMBERG_VIEWER). Without, pages are complete all the same.
bool viewer_is_built();

struct ViewedOperation {
  std::string name;  // above it where there are several
  std::string dir;   // where its model lies
};

struct Viewer {
  html::Markup section;  // nothing where none of the folders has a model, or the build no viewer
  std::string nonce;     // of its scripts: no other runs in the page
};
Viewer viewer(const std::vector<ViewedOperation>& operations, const Words& words = {});

/// A model packed for a page. InputError (`file`): it is none.
std::string packed_model(const std::string& glb, const std::string& file);

}  // namespace limberg

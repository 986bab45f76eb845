#pragma once
// An operation that was not carried out whole: actions that were refused (--keep-going), or a person who stopped it.
#include <string>

#include "app/assembly/operation.h"
#include "app/result/run_result.h"

namespace limberg {

/// `commands`, `refused` and `interrupted` of result.json.
void fill_unfinished(ResultRun& run, ResultStory& story, const OperationOutcome& outcome);
/// Says each refused action with its line and reason, and after how many of `total` actions it was stopped. False when
/// there is neither: the operation is whole.
bool tell_unfinished(const OperationOutcome& outcome, size_t total, const std::string& script);

}  // namespace limberg

#include "app/commands/unfinished.h"

#include <fmt/format.h>

#include "app/result/progress.h"

namespace limberg {

void fill_unfinished(ResultRun& run, ResultStory& story, const OperationOutcome& outcome) {
  run.interrupted = outcome.interrupted;
  story.commands = int64_t(outcome.done);
  story.refused.emplace();
  for (const RefusedAction& x : outcome.refused) story.refused->push_back({{}, double(x.line), x.action, x.reason});
}

bool tell_unfinished(const OperationOutcome& outcome, size_t total, const std::string& script) {
  for (const RefusedAction& x : outcome.refused)
    say(fmt::format("{}:{}: {} refused: {}", script, x.line, x.action, x.reason));
  if (!outcome.refused.empty())
    say(fmt::format("{} of {} actions were refused; the others are carried out", outcome.refused.size(), total));
  if (outcome.interrupted)
    say(fmt::format("interrupted after {} of {} actions; what was done by then is told and written", outcome.done,
                    total));
  return outcome.interrupted || !outcome.refused.empty();
}

}  // namespace limberg

#pragma once
// The sections of a report, in their order on the page. Each is a function of its name in a file of its own,
// sections/NAME.cpp: from the result to Markup, and nothing when there is nothing to show. A new section is that file
// and one line here.
#include "app/report/parts.h"

#define LIMBERG_REPORT_SECTIONS(X)                             \
  X(uncertainty) /* of a sampled study: bands and shares */    \
  X(study)       /* a family's charts, bars and rows */        \
  X(story)       /* the operation, stage by stage */           \
  X(gallery)     /* more pictures, before and after */         \
  X(verdict)     /* everything that was looked at */           \
  X(tension)     /* maps of the skin */                        \
  X(sutures)     /* force and gap of each stitch */            \
  X(closing)     /* what it came to: forces, tables, charts */ \
  X(exercise)    /* lesson, tolerances, figures of the hand */ \
  X(balance)     /* volume and forces that must add up */      \
  X(convergence) /* the same on finer cells */                 \
  X(timing)      /* the three lanes */                         \
  X(residual)    /* how close to equilibrium */                \
  X(figures)     /* every number */                            \
  X(script)      /* what was done */                           \
  X(again)       /* how to make the result again */

namespace limberg::sections {

#define X(name) html::Markup name(const ReportSource& source);
LIMBERG_REPORT_SECTIONS(X)
#undef X

/// All of them.
html::Markup all(const ReportSource& source);

// What stands round them.
html::Markup opening(const ReportSource& source);  // what the result is of
html::Markup summary(const ReportSource& source);  // verdict, picture, key figures
html::Markup footer(const ReportSource& source);   // what made it

}  // namespace limberg::sections

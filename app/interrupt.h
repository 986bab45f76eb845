#pragma once
// Ctrl-C and termination: a flag that long work looks at, so that it ends cleanly and keeps what was recorded.
namespace limberg {

/// From now on SIGINT and SIGTERM set the flag; a second one ends the program at once. SIGPIPE is ignored.
void catch_interrupts();
bool interrupted();

}  // namespace limberg

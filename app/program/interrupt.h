#pragma once
// Ctrl-C, termination and a closed terminal: what has something to keep ends in order, everything else at once.
namespace limberg {

/// From now on SIGINT, SIGTERM and SIGHUP end the program with one line and exit status 3. Results appear whole or not
/// at all (write_whole_file), so nothing is half written. SIGPIPE is ignored.
void end_at_interrupts();
/// From now on they set a flag instead, which long work looks at so that
/// it keeps what was recorded; a second one ends the program at once.
void catch_interrupts();
bool interrupted();

}  // namespace limberg

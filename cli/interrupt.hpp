#pragma once

/// SIGINT, SIGTERM and SIGHUP (a terminal that is closed) as a question that a loop can ask. The second signal ends the program at once.
namespace cli {

void catch_interrupts();
/// The signal that came, or 0.
int interrupt();

}  // namespace cli

// The adapter between its client, on standard input and output, and the run, which is a process of its own.
#pragma once

namespace meld::dap {

// Serves one session. Returns the exit code: 0 after `disconnect`, 1 if the client has gone without a word, 2 if what it sends are no
// messages, which standard error says.
int serve();

}  // namespace meld::dap

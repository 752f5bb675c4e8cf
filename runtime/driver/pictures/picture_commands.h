// The command lines of the commands that make pictures of a run.
#pragma once

#include "runtime/driver/questions/question_commands.h"

namespace CLI {
class App;
}

namespace meld::driver {

void add_shot(CLI::App& app, Asking& asking);
void add_movie(CLI::App& app, Asking& asking);
void add_export(CLI::App& app, Asking& asking);
// How catoms look and from where they are seen, for a picture of a world alone.
void add_start_view(CLI::App& command, PictureOptions& picture);
// After a command line of these has been read: its options become flags of the inquiry, as processes get them.
void note_flags(Asking& asking);

}  // namespace meld::driver

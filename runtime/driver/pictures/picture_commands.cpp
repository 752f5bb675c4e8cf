#include "runtime/driver/pictures/picture_commands.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "runtime/driver/setup/option_groups.h"

namespace meld::driver {

namespace {

// Of the options that are handed on to processes.
constexpr const char* kGroup = "Picture";

template <class Value>
CLI::Option* add(CLI::App& command, const char* name, Value& value, const char* type, const char* text) {
    return command.add_option(name, value, text)->type_name(type)->group(kGroup);
}

CLI::App* add_command(CLI::App& app, Asking& asking, const std::string& name, const std::string& about, decltype(PictureOptions::of) of) {
    RunOptions& run = asking.run;
    run.debug = {.history = "0", .inquiry = Inquiry{.command = name, .words = {}}, .picture = PictureOptions{.of = std::move(of)}};
    CLI::App* const command = app.add_subcommand(name, about);
    command->add_option("TARGET", run.program, "A program, which is run; or a recording; or a folder of checkpoints")->required();
    return command;
}

void add_steps(CLI::App& c, PictureOptions& picture) {
    c.add_flag("--steps", picture.steps, "Paint a recording as it is, and do not make its run again: only ticks that it has, and no BODY")
        ->group(kGroup);
}

void add_form(CLI::App& c, PictureOptions& picture) {
    add(c, "--form", picture.form, "FORM",
        "Draw sphere, cube, rounded (a cube with round edges), disc or hexagon; otherwise what fits the lattice");
    add(c, "--catom-size", picture.catom_size, "FACTOR",
        "Draw catoms so much smaller; otherwise 0.5 where lines are among them in space, or 1");
}

void add_camera(CLI::App& c, PictureOptions& picture) {
    add(c, "--size", picture.size, "WxH", "Pixels of the whole picture")->capture_default_str();
    add(c, "--azimuth", picture.azimuth, "DEGREES", "Where the camera stands, from the x axis towards the y axis");
    add(c, "--elevation", picture.elevation, "DEGREES", "How high the camera stands");
    add(c, "--angle", picture.angle, "DEGREES", "How much the camera sees; 0: parallel, without perspective");
    add(c, "--zoom", picture.zoom, "FACTOR", "Show the middle larger")->capture_default_str();
    c.add_flag("--edges", picture.edges, "Draw lines at the edges of catoms, and around what is in front")->group(kGroup);
    c.add_flag("--ground", picture.ground, "Show shadows on a floor")->group(kGroup);
    c.add_flag("--scale", picture.scale, "Draw a scale")->group(kGroup);
    c.add_flag("--bare", picture.bare, "Write neither ticks nor a legend")->group(kGroup);
    add(c, "--title", picture.title, "TEXT", "Write this above");
    add(c, "--background", picture.background, "COLOUR", "As #RRGGBB, or white, black, grey or transparent")->capture_default_str();
    add(c, "--samples", picture.samples, "INT", "Rays through a pixel, along each side")
        ->capture_default_str()
        ->check(cli::whole_number(1, 16));
}

// Which catoms are shown, and how.
void add_look(CLI::App& c, PictureOptions& picture) {
    add(c, "--colour,--color", picture.colour, "BODY",
        "Colour catoms by the last variable, as in 'dist(A, D)'; with one variable, those for which it holds");
    add(c, "--map", picture.map, "NAME", "The colours of numbers: viridis, cividis, magma, coolwarm or grey")->capture_default_str();
    add(c, "--range", picture.range, "LOW:HIGH", "The numbers at the ends of the colours; otherwise the least and the greatest");
    add(c, "--only", picture.only, "BODY", "Show only catoms for which it holds");
    add(c, "--hide", picture.hide, "BODY", "Do not show catoms for which it holds");
    add_form(c, picture);
}

// What is drawn besides, and from where it is seen.
void add_view(CLI::App& c, PictureOptions& picture) {
    add(c, "--links", picture.links, "BODY",
        "Draw a line from a catom to the next variable that is a catom, or along a vec3. Without --colour a number behind it colours it");
    add(c, "--arrows", picture.arrows, "BODY", "The same with an arrow");
    add(c, "--labels", picture.labels, "BODY", "Write the value of the last variable at the catom");
    add(c, "--callout", picture.callouts, "@N=TEXT|BODY",
        "Write this beside the picture, with a line to the catom; or for each catom of a body the value of its last variable; repeatable")
        ->take_all()
        ->allow_extra_args(false);
    add_camera(c, picture);
}

}  // namespace

void add_shot(CLI::App& app, Asking& asking) {
    CLI::App& c = *add_command(app, asking, "shot",
                               "Take a picture of a run, as a PNG file. A BODY is in Meld, and about its first variable that is a catom.\n"
                               "Example: meldsim shot examples/meld/gradient.meld -o gradient.png --colour 'dist(A, D)'",
                               ShotOptions{});
    PictureOptions& picture = *asking.run.debug->picture;
    ShotOptions& shot = std::get<ShotOptions>(picture.of);
    add(c, "-o,--output", picture.file, "FILE", "The picture; - for standard output")->required();
    add(c, "--tick", shot.ticks, "T[,T...]", "Show the run after these ticks, side by side, as in 0,20,end; otherwise where it ends")
        ->delimiter(',');
    add(c, "--columns", shot.columns, "INT", "How many frames of several stand side by side; otherwise as they fit")
        ->check(cli::whole_number(1, 1000));
    add_steps(c, picture);
    add_look(c, picture);
    add_view(c, picture);
    add_target_options(c, asking);
}

void add_movie(CLI::App& app, Asking& asking) {
    CLI::App& c = *add_command(app, asking, "movie",
                               "Make a film of a run. A BODY is in Meld, and about its first variable that is a catom.\nExample: "
                               "meldsim movie examples/meld/gradient.meld -o gradient.mp4 --colour 'dist(A, D)'",
                               MovieOptions{});
    PictureOptions& picture = *asking.run.debug->picture;
    MovieOptions& movie = std::get<MovieOptions>(picture.of);
    add(c, "-o,--output", picture.file, "FILE", "The film, .mp4 or .webm, which ffmpeg makes; or FOLDER/ for numbered pictures")
        ->required();
    add(c, "--from", movie.from, "T", "Begin after this tick; end: where the run ends. Otherwise before the first tick");
    add(c, "--to", movie.to, "T", "End with this tick; otherwise where the run ends");
    CLI::Option* const every = add(c, "--every", movie.every, "INT", "Ticks from a frame to the next");
    every->check(cli::whole_number(1, std::numeric_limits<std::int32_t>::max()));
    add(c, "--seconds", movie.seconds, "SECONDS", "The film takes no longer: frames are so many ticks apart")
        ->default_str(fmt::format("{}", kMovieSeconds))
        ->excludes(every);
    add(c, "--hold", movie.hold, "SECONDS", "The last tick stays for so long")->capture_default_str();
    add(c, "--fps", movie.fps, "NUMBER", "Frames a second")->capture_default_str();
    CLI::Option* const turn = add(c, "--turn", movie.turn, "DEGREES", "The camera goes around so far, as --azimuth counts");
    CLI::Option* const key = add(c, "--key", movie.keys, "T,AZIMUTH,ELEVATION,ZOOM",
                                 "After this tick the camera is there; between two keys it moves smoothly; repeatable");
    key->take_all()->allow_extra_args(false)->excludes(turn);
    add_steps(c, picture);
    add_look(c, picture);
    add_view(c, picture);
    for (const char* fixed : {"--azimuth", "--elevation", "--zoom"}) key->excludes(c.get_option(fixed));
    add_target_options(c, asking);
}

void add_export(CLI::App& app, Asking& asking) {
    CLI::App& c =
        *add_command(app, asking, "export",
                     "Write what is shown of a run for other programs: points (.ply), solids (.glb), tables (.csv) or atoms (.xyz); "
                     "or a recording in which every step is whole (.vtkhdf). A "
                     "BODY is in Meld, and about its first variable that is a catom.\nExample: meldsim export "
                     "examples/meld/gradient.meld -o gradient.ply --colour 'dist(A, D)'",
                     ExportOptions{});
    PictureOptions& picture = *asking.run.debug->picture;
    add(c, "-o,--output", picture.file, "FILE",
        "What is written: .ply, .glb, .csv, .xyz or, of a recording, .vtkhdf; TICK in the name makes a file of each tick")
        ->required();
    add(c, "--tick", std::get<ExportOptions>(picture.of).ticks, "T[,T...]",
        "Write the run after these ticks, as in 0,20,end; several in .csv and .xyz files, or with TICK in the name. Otherwise where it "
        "ends")
        ->delimiter(',');
    add_look(c, picture);
    add_target_options(c, asking);
}

void add_start_view(CLI::App& command, PictureOptions& picture) {
    add_form(command, picture);
    add_camera(command, picture);
}

void note_flags(Asking& asking) {
    std::vector<std::string>& flags = asking.run.debug->inquiry->flags;
    for (const CLI::Option* option : asking.command->get_options())
        if (option->get_group() == kGroup && option->count() > 0)
            for (const std::string& value : option->results()) {
                flags.push_back(option->get_name());
                if (option->get_expected_max() > 0) flags.push_back(value);
            }
}

}  // namespace meld::driver

#include "runtime/driver/study/study_plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <functional>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include "runtime/ask/query/query.h"
#include "runtime/base/did_you_mean.h"
#include "runtime/base/files/input_file.h"
#include "runtime/base/hash.h"
#include "runtime/base/version.h"
#include "runtime/driver/run/run.h"
#include "runtime/driver/setup/inputs.h"
#include "runtime/driver/setup/run_words.h"
#include "runtime/driver/study/study_world.h"
#include "runtime/world/file/world_file.h"

namespace meld::driver {

namespace {

constexpr std::uint64_t kMostFile_bytes = std::uint64_t{1} << 30;
constexpr std::size_t kMostRows = 10'000'000;

bool has_parameter(const ModuleInfo& info, const std::string& name) {
    return std::ranges::any_of(std::span(info.parameters, info.parameter_count), [&](const ParameterInfo& p) { return name == p.name; });
}

std::uint64_t hash_sources(const ModuleInfo& info) {
    std::uint64_t hash = 0;
    for (const SourceInfo& source : std::span(info.sources, info.source_count)) hash = hash_combine(hash, hash_text(source.text));
    return hash;
}

// What of a world decides how a program is compiled for it.
std::string form_key(const std::string& world) {
    if (world.empty()) return "";
    const world::PortKeys ports = world::port_keys(world);
    return fmt::format("{}{}{} {} {} {}", world::asks_for_graph(world), world::asks_for_links(world), world::says_acyclic(world),
                       ports.lattice, ports.ports, fmt::join(world::programs_named(world), " "));
}

Error at_place(const std::string& place, Error error) {
    error.problem = fmt::format("{}: {}", place, error.problem);
    return error;
}

}  // namespace

RunOptions StudyPlan::base_options(std::size_t program, const std::string& world_path) const {
    RunOptions options;
    options.program = study_.programs[program].path;
    options.world = world_path;
    options.events = study_.events;
    options.library_paths = study_.library;
    options.link = study_.link;
    options.extensions = study_.extensions;
    options.threads = study_.threads;
    options.timeout_seconds = study_.timeout_seconds;
    options.quiet = true;
    if (study_.ticks) options.ticks = *study_.ticks;
    if (!study_.until.empty()) options.watch.push_back(study_.until);
    for (const StudyDemand& each : study_.demands) (each.never ? options.never : options.expect).push_back(each.name + ": " + each.body);
    return options;
}

RunOptions StudyPlan::options(const StudyRow& row) const {
    RunOptions options = base_options(row.program, row.world_path);
    options.set = row.set;
    if (row.seed) options.seed = static_cast<std::int64_t>(*row.seed);
    return options;
}

std::vector<std::string> StudyPlan::command(const StudyRow& row, const std::string& from) const { return run_words(options(row), from); }

Result<void> StudyPlan::read_questions(StudyModule& module) {
    for (const StudyMeasure& measure : study_.measures) {
        module.measures.emplace_back();
        if (measure.body.empty()) continue;
        Result<inspect::Program> program = inspect::read_question(module.info(), measure.body);
        if (!program) return tl::unexpected<Error>(at_place(fmt::format("{}: [measure] {}", measure.place, measure.name), program.error()));
        module.measures.back().emplace(std::move(*program));
    }
    for (const StudyDemand& demand : study_.demands) {
        const Result<inspect::Program> program = inspect::read_question(module.info(), demand.body);
        if (!program)
            return tl::unexpected<Error>(
                at_place(fmt::format("{}: [{}] {}", demand.place, demand.never ? "never" : "expect", demand.name), program.error()));
    }
    return {};
}

Result<std::size_t> StudyPlan::module_for(std::size_t program, const std::string& world_path) {
    RunOptions options = base_options(program, world_path);
    // It is that of a run.
    options.timeout_seconds = 0;
    const std::string name = fmt::format("{} {}", program, form_key(world_path));
    if (const auto found = module_numbers_.find(name); found != module_numbers_.end()) return found->second;
    const Result<std::string> path = compile_program(options);
    if (!path) return tl::unexpected<Error>(path.error());
    Result<Module> loaded = load_module(*path, kAbiVersion);
    if (!loaded) return tl::unexpected<Error>(loaded.error());
    StudyModule module{.path = *path, .module = std::move(*loaded), .measures = {}};
    if (auto read = read_questions(module); !read) return tl::unexpected<Error>(read.error());
    text_hashes_.push_back(hash_sources(module.info()));
    modules_.push_back(std::move(module));
    return module_numbers_[name] = modules_.size() - 1;
}

// The first of the worlds, so that a mistake is told once, and not by each of its runs.
Result<void> StudyPlan::check_world(const StudyWorld& world, const ComposedWorld& composed) const {
    // One that does not say where catoms are is whole only with a program.
    if (composed.path.empty() || !world::says_places(composed.path)) return {};
    const Result<world::World> read = world::read_world(composed.path);
    if (read) return {};
    Error error = read.error();
    // Nobody has seen the file that is made of a table.
    if (const std::string start = composed.path + ":"; world.keys != nullptr && error.problem.starts_with(start)) {
        const toml::source_position at = world.keys->source().begin;
        const std::size_t colon = error.problem.find(": ", start.size());
        error.problem = fmt::format("{}:{}:{}: [world]{}", study_.path, at.line, at.column,
                                    colon == std::string::npos ? "" : error.problem.substr(colon));
    }
    return tl::unexpected<Error>(error);
}

Result<void> StudyPlan::add_program(std::size_t program) {
    for (const StudyWorld& each : study_.worlds) {
        const std::string own = each.path.empty() && each.keys == nullptr ? world_path(base_options(program, "")) : each.path;
        Result<WorldTemplate> form = each.keys != nullptr ? WorldTemplate(*each.keys, study_.folder) : WorldTemplate::read(own);
        if (!form) return tl::unexpected<Error>(form.error());
        // The constants of a program do not depend on its world, except that this may bring programs of its own.
        std::optional<std::size_t> first;
        std::map<std::vector<std::size_t>, std::pair<ComposedWorld, std::size_t>> made;
        const auto world_for = [&](const Chosen& chosen,
                                   const std::vector<std::size_t>& which) -> Result<std::pair<ComposedWorld, std::size_t>> {
            if (const auto found = made.find(which); found != made.end()) return found->second;
            const Result<ComposedWorld> composed = form->compose(chosen, worlds_folder_);
            if (!composed) return tl::unexpected<Error>(composed.error());
            const Result<std::size_t> module = module_for(program, composed->path);
            if (!module) return tl::unexpected<Error>(module.error());
            return made[which] = std::pair(*composed, *module);
        };
        // Which parameters are of the world is known before there is a module; a module is needed to know the constants.
        std::vector<bool> of_world, of_program;
        Chosen start;
        std::vector<std::size_t> start_which;
        for (const StudyAxis& axis : study_.axes) {
            const bool mentioned = form->mentions(axis.name);
            of_world.push_back(mentioned || axis.name.find('.') != std::string::npos);
            if (of_world.back()) start.emplace_back(&axis, &axis.values.front());
            if (of_world.back() && !mentioned && !names_world_key(axis.name))
                return fail(fmt::format("{}: [set] {}: worlds have no such section", axis.place, axis.name),
                            did_you_mean(axis.name.substr(0, axis.name.find('.')), world_keys()));
        }
        for (std::size_t i = 0; i < of_world.size(); ++i) start_which.push_back(0);
        const auto begin = world_for(start, start_which);
        if (!begin) return tl::unexpected<Error>(begin.error());
        const ModuleInfo& info = modules_[begin->second].info();
        for (std::size_t i = 0; i < study_.axes.size(); ++i) {
            const StudyAxis& axis = study_.axes[i];
            of_program.push_back(has_parameter(info, axis.name));
            if (!of_program[i] && !of_world[i] && names_world_key(axis.name)) of_world[i] = true;
            used_[i] = used_[i] || of_program[i] || of_world[i];
        }
        made.clear();
        if (auto checked = check_world(each, begin->first); !checked) return checked;

        std::vector<std::size_t> choice(study_.axes.size());
        const std::function<Result<void>(std::size_t)> go = [&](std::size_t depth) -> Result<void> {
            if (depth < study_.axes.size()) {
                const bool concerns = of_world[depth] || of_program[depth];
                for (choice[depth] = 0; choice[depth] < (concerns ? study_.axes[depth].values.size() : 1); ++choice[depth])
                    if (auto done = go(depth + 1); !done) return done;
                return {};
            }
            StudyRow row{.program = program, .world = each.keys != nullptr ? "[world]" : each.name.empty() ? own : each.name};
            Chosen chosen;
            std::vector<std::size_t> which;
            std::uint64_t set_hash = 0;
            for (std::size_t i = 0; i < choice.size(); ++i) {
                const StudyAxis& axis = study_.axes[i];
                const StudyValue& value = axis.values[choice[i]];
                row.values.push_back(of_world[i] || of_program[i] ? value.plain : "");
                which.push_back(of_world[i] ? choice[i] : 0);
                if (of_world[i]) chosen.emplace_back(&axis, &value);
                if (of_program[i]) row.set.push_back(fmt::format("{}={}", axis.name, value.literal));
            }
            // In the order of names: their order in the file means nothing.
            std::vector<std::string> settings = row.set;
            std::ranges::sort(settings);
            for (const std::string& setting : settings) set_hash = hash_combine(set_hash, hash_text(setting));
            const auto world = world_for(chosen, which);
            if (!world) return tl::unexpected<Error>(world.error());
            row.world_path = world->first.path;
            row.module = world->second;
            std::uint64_t hash = hash_text(kVersion);
            for (const std::uint64_t part : {text_hashes_[row.module], world->first.hash, set_hash, options_hash_})
                hash = hash_combine(hash, part);
            const auto add = [&](std::optional<std::uint64_t> seed) {
                row.seed = seed;
                row.key = fmt::format("{:016x}", hash_combine(hash, seed ? *seed + 1 : 0));
                rows_.push_back(row);
            };
            if (study_.seeds.empty()) add(std::nullopt);
            for (const std::uint64_t seed : study_.seeds) add(seed);
            if (rows_.size() > kMostRows)
                return fail(fmt::format("{}: the study has more than {} runs", study_.path, kMostRows), "Leave out some values");
            return {};
        };
        if (auto done = go(0); !done) return done;
    }
    return {};
}

// A parameter that no row depends on is a mistake.
Result<void> StudyPlan::check_axes() {
    for (std::size_t i = 0; i < study_.axes.size(); ++i) {
        if (used_[i]) continue;
        const StudyAxis& axis = study_.axes[i];
        std::set<std::string_view> names;
        for (const StudyModule& module : modules_)
            for (const ParameterInfo& p : std::span(module.info().parameters, module.info().parameter_count)) names.emplace(p.name);
        const std::vector<std::string_view> known(names.begin(), names.end());
        const auto near = nearest_name(axis.name, known);
        return fail(
            fmt::format("{}: [set] {}: the program has no such constant, and no world has {{{}}} in it", axis.place, axis.name, axis.name),
            near            ? fmt::format("Did you mean '{}'?", *near)
            : known.empty() ? "The program has no constants that can be set: write const NAME = VALUE."
                            : fmt::format("Its constants are {}", fmt::join(known, ", ")));
    }
    return {};
}

Result<StudyPlan> StudyPlan::make(Study study, const std::string& worlds_folder) {
    StudyPlan plan;
    plan.study_ = std::move(study);
    plan.worlds_folder_ = worlds_folder;
    const Study& s = plan.study_;
    plan.used_.resize(s.axes.size());
    std::uint64_t hash = hash_text(fmt::format("{} {}", s.ticks.value_or(-1), s.until));
    for (const auto* files : {&s.events, &s.link, &s.extensions})
        for (const std::string& file : *files) {
            const Result<std::string> text = read_input(file, kMostFile_bytes);
            if (!text) return tl::unexpected<Error>(text.error());
            hash = hash_combine(hash, hash_text(*text));
        }
    plan.options_hash_ = hash;
    for (std::size_t program = 0; program < s.programs.size(); ++program)
        if (auto added = plan.add_program(program); !added) return tl::unexpected<Error>(added.error());
    if (auto checked = plan.check_axes(); !checked) return tl::unexpected<Error>(checked.error());
    return plan;
}

Result<std::size_t> row_named(const StudyPlan& plan, const std::string& name) {
    const std::vector<StudyRow>& rows = plan.rows();
    std::size_t number = 0;
    const auto read = std::from_chars(name.data(), name.data() + name.size(), number);
    if (read.ec == std::errc{} && read.ptr == name.data() + name.size() && number >= 1 && number <= rows.size()) return number - 1;
    for (std::size_t i = 0; i < rows.size(); ++i)
        if (name.size() >= 4 && rows[i].key.starts_with(name)) return i;
    return fail(fmt::format("the study has no row '{}'", name),
                fmt::format("Its rows are 1 to {}, as in the column `row` of the table", rows.size()));
}

}  // namespace meld::driver

#include "runtime/driver/grade/submission.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>
#include <utility>

#include "compiler/diagnostics/diagnostics.h"
#include "compiler/front/front_end.h"
#include "compiler/source/source.h"
#include "compiler/syntax/parse.h"
#include "runtime/base/files/input_file.h"
#include "runtime/base/hash.h"
#include "runtime/base/units.h"
#include "runtime/driver/grade/likeness.h"

namespace meld::driver {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMostSubmission_bytes = std::uint64_t{1} << 20;
constexpr std::size_t kMostFiles = 100;
constexpr std::size_t kMostFileName = 80;

// Without following a link; of what is neither, what it is in words.
struct Kind {
    bool file = false, folder = false;
    std::string words = {};
};
Kind kind_of(const std::string& path) {
    struct stat about{};
    if (lstat(path.c_str(), &about) != 0) return {.words = "cannot be read"};
    if (S_ISREG(about.st_mode)) return {.file = true};
    if (S_ISDIR(about.st_mode)) return {.folder = true};
    return {.words = S_ISLNK(about.st_mode) ? "is a link" : S_ISFIFO(about.st_mode) ? "is a pipe" : "is neither a file nor a folder"};
}

class SubmissionReader {
  public:
    SubmissionReader(std::string path, const Exercise& exercise) : path_(std::move(path)), exercise_(exercise) {}

    Submission run(std::string name) {
        out_.name = std::move(name);
        out_.problem = read();
        if (!out_.problem.empty()) out_.files.clear();
        for (const auto& [file, text] : out_.files) out_.hash = hash_combine(hash_combine(out_.hash, hash_text(file)), hash_text(text));
        return std::move(out_);
    }

  private:
    // Returns the problem.
    std::string read() {
        const Kind kind = kind_of(path_);
        if (!kind.file && !kind.folder) return fmt::format("it {}. Put the file itself there", kind.words);
        if (kind.file) {
            if (!path_.ends_with(".meld")) return "it is not a .meld file";
            out_.program = fs::path(path_).filename().string();
            return add(out_.program, path_);
        }
        if (std::string problem = add_folder(path_, "", 0); !problem.empty()) return problem;
        return choose_program();
    }

    std::string add_folder(const std::string& folder, const std::string& within, int depth) {
        constexpr int kMostDepth = 8;
        if (depth > kMostDepth) return fmt::format("its folders are nested more than {} deep", kMostDepth);
        std::error_code error;
        std::vector<std::string> names;
        for (fs::directory_iterator each(folder, error), end; !error && each != end; each.increment(error))
            names.push_back(each->path().filename().string());
        if (error) return fmt::format("{} cannot be read: {}", within.empty() ? "its folder" : within, error.message());
        std::ranges::sort(names);
        for (const std::string& name : names) {
            if (name.starts_with('.')) continue;
            const Kind kind = kind_of(folder + "/" + name);
            std::string problem;
            if (kind.folder)
                problem = add_folder(folder + "/" + name, within + name + "/", depth + 1);
            else if (kind.file && name.ends_with(".meld"))
                problem = add(within + name, folder + "/" + name);
            else if (!kind.file)
                problem = fmt::format("{} {}. Put the file itself there", within + name, kind.words);
            if (!problem.empty()) return problem;
        }
        return "";
    }

    std::string add(const std::string& name, const std::string& path) {
        if (out_.files.size() == kMostFiles) return fmt::format("it has more than {} programs", kMostFiles);
        Result<std::string> text = read_input(path, kMostSubmission_bytes - bytes_);
        if (!text) {
            std::error_code error;
            const bool large = fs::file_size(path, error) > kMostSubmission_bytes - bytes_ && !error;
            return large ? fmt::format("its text has more than {}", format_bytes(kMostSubmission_bytes))
                         : fmt::format("{} cannot be read: {}", name, text.error().problem);
        }
        bytes_ += text->size();
        out_.files.emplace_back(name, std::move(*text));
        return "";
    }

    // The only one at the top, or that with the name of the program that students begin with.
    std::string choose_program() {
        const std::string wanted = fs::path(exercise_.program).filename().string();
        std::vector<std::string> top;
        for (const auto& [name, text] : out_.files)
            if (name.find('/') == std::string::npos) top.push_back(name);
        if (top.empty()) return "it has no .meld file";
        if (top.size() > 1 && std::ranges::find(top, wanted) == top.end())
            return fmt::format("it has {} programs, and none is called {}", top.size(), wanted);
        out_.program = top.size() == 1 ? top.front() : wanted;
        return "";
    }

    std::string path_;
    const Exercise& exercise_;
    Submission out_;
    std::uint64_t bytes_ = 0;
};

std::string file_name(const std::string& name, std::set<std::string>& taken) {
    std::string plain = name.substr(0, kMostFileName);
    std::ranges::replace_if(plain, [](unsigned char c) { return !std::isalnum(c) && c != '.' && c != '-' && c != '_'; }, '_');
    if (plain.empty() || plain.front() == '.' || plain.front() == '-') plain.insert(plain.begin(), '_');
    // File systems may not tell small letters from capitals.
    const auto folded = [](std::string text) {
        std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
        return text;
    };
    std::string out = plain;
    for (int i = 2; !taken.insert(folded(out)).second; ++i) out = fmt::format("{}-{}", plain, i);
    return out;
}

// Whether a path, links followed, is below one of these folders.
bool is_within(const std::string& path, const std::vector<std::string>& folders) {
    std::error_code error;
    const fs::path real = fs::weakly_canonical(path, error);
    return !error && std::ranges::any_of(folders, [&](const std::string& folder) {
        const std::string from_there = real.lexically_relative(fs::weakly_canonical(folder, error)).string();
        return !from_there.empty() && from_there != ".." && !from_there.starts_with("../");
    });
}

// Of the files that a program includes, the first one that is neither its own nor of the exercise; empty: none. The program is parsed as
// the compiler does it, which reads such a file, but nobody sees what is in it.
std::string strange_file(const std::string& program, const Exercise& exercise) {
    source::FileSet files;
    diagnostics::Reporter report;
    const std::uint32_t prelude = front::add_prelude(files);
    const auto file = files.read(program);
    if (!file) return "";
    syntax::ParseOptions options;
    options.library_paths = exercise.library;
    const front::ParsedProgram parsed = front::parse_program(files, *file, prelude, report, options);
    std::vector<std::string> allowed = exercise.library;
    allowed.emplace_back(".");
    for (const syntax::Tree::Include& include : parsed.program.includes) {
        if (!include.file || !files.file(*include.file).on_disk()) continue;
        const std::string& path = files.file(*include.file).path();
        if (is_within(path, allowed)) continue;
        const source::Place place = files.begin(include.where);
        return fmt::format("{}:{}:{}: {} is not part of the submission", files.file(include.where).path(), place.line, place.column, path);
    }
    return "";
}

}  // namespace

Result<std::vector<Submission>> read_submissions(const std::string& path, const Exercise& exercise) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    const fs::path given = fs::path(path).lexically_normal();
    std::vector<std::string> names;
    fs::path folder = given;
    if (fs::is_regular_file(status)) {
        folder = given.parent_path().empty() ? "." : given.parent_path();
        names.push_back(given.filename().string());
    } else if (fs::is_directory(status)) {
        for (fs::directory_iterator each(given, error), end; !error && each != end; each.increment(error))
            names.push_back(each->path().filename().string());
        if (error) return fail(fmt::format("{} cannot be read: {}", path, error.message()));
        std::erase_if(names, [](const std::string& name) { return name.starts_with('.'); });
        if (names.empty()) return fail(fmt::format("{} is empty", path), "Put a file or a folder for each student there");
    } else {
        return fail(fmt::format("there is no folder {}", path), "Give the folder with a file or a folder for each student");
    }
    std::ranges::sort(names);
    std::vector<Submission> all;
    std::set<std::string> once, taken;
    for (const std::string& name : names) {
        std::string shown = name.ends_with(".meld") && name.size() > 5 ? name.substr(0, name.size() - 5) : name;
        // A file beside a folder of the same name.
        if (!once.insert(shown).second) shown = name;
        once.insert(shown);
        all.push_back(SubmissionReader((folder / name).string(), exercise).run(shown));
        all.back().file = file_name(shown, taken);
    }
    return all;
}

Reading read_program(const Submission& submission, const Exercise& exercise) {
    Reading out;
    out.problem = strange_file(submission.program, exercise);
    syntax::ParseOptions alone;
    alone.follow_includes = false;
    source::FileSet files;
    diagnostics::Reporter report;
    std::vector<syntax::Tree> trees;
    for (const auto& [name, text] : submission.files) trees.push_back(syntax::parse(files, files.add(name, text), report, alone));
    if (report.has_errors()) return out;
    source::FileSet start;
    diagnostics::Reporter silent;
    std::set<std::string> fixed;
    if (const auto file = start.read(exercise.program)) fixed = declared_names(syntax::parse(start, *file, silent, alone));
    out.likeness = likeness(trees, fixed);
    return out;
}

}  // namespace meld::driver

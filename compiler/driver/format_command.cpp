// Every file is processed, whatever is wrong with the earlier ones. A file is replaced as a whole, so none is ever half written.
#include "compiler/driver/format_command.h"

#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <iterator>

#include "compiler/driver/show_messages.h"
#include "compiler/format/format.h"
#include "runtime/base/files/output_file.h"
#include "runtime/base/terminal/terminal_text.h"

namespace meld::driver {

namespace {

Result<std::uint32_t> read(source::FileSet& files, const std::string& path) {
    if (path != "-") return files.read(path, InputKind::FileOrPipe);
    std::string text{std::istreambuf_iterator<char>(std::cin), std::istreambuf_iterator<char>()};
    return files.add("<standard input>", std::move(text));
}

int format_one(const std::string& path, const FormatOptions& options) {
    source::FileSet files;
    const Result<std::uint32_t> file = read(files, path);
    if (!file) return fail_with(file.error());
    diagnostics::Reporter report;
    const auto formatted = format::format(files, *file, report);
    if (!formatted) return fail_with(formatted.error());
    if (!*formatted) {
        const auto colour = isatty(STDERR_FILENO) ? diagnostics::Colour::Always : diagnostics::Colour::Never;
        std::cerr << diagnostics::render_text(files, report.sorted(), colour);
        return static_cast<int>(ExitCode::ProgramWrong);
    }
    const std::string& text = **formatted;
    const bool changes = text != files.file(*file).text();
    if (options.check) {
        if (changes) std::cout << visible(path) << "\n";
        return changes ? static_cast<int>(ExitCode::ProgramWrong) : 0;
    }
    if (options.to_stdout || path == "-") {
        std::cout << text;
        return 0;
    }
    if (!changes) return 0;
    if (const auto written = write_file(path, text); !written) return fail_with(written.error());
    std::cerr << visible(path) << ": formatted\n";
    return 0;
}

}  // namespace

int run_format(const FormatOptions& options) {
    int worst = 0;
    for (const std::string& path : options.files) worst = std::max(worst, format_one(path, options));
    return worst;
}

}  // namespace meld::driver

// Diagnostics as one JSON array, for editors and other programs.
#include <nlohmann/json.hpp>

#include "compiler/diagnostics/diagnostics.h"

namespace meld::diagnostics {

namespace {

using Json = nlohmann::ordered_json;

std::string_view severity_name(Severity severity) {
    switch (severity) {
        case Severity::Error:
            return "error";
        case Severity::Warning:
            return "warning";
        case Severity::Note:
            return "note";
    }
    return "error";
}

void put_span(Json& object, const source::FileSet& files, Span span) {
    const source::Place begin = files.begin(span);
    const source::Place end = files.end(span);
    object["path"] = files.file(span).path();
    object["line"] = begin.line;
    object["column"] = begin.column;
    object["end_line"] = end.line;
    object["end_column"] = end.column;
}

Json to_json(const source::FileSet& files, const Diagnostic& diagnostic) {
    const KindInfo& kind = info(diagnostic.kind);
    Json object;
    object["code"] = kind.code;
    object["severity"] = severity_name(kind.severity);
    object["message"] = diagnostic.message;
    put_span(object, files, diagnostic.span);
    object["labels"] = Json::array();
    for (const Label& label : diagnostic.labels) {
        Json entry;
        entry["text"] = label.text;
        put_span(entry, files, label.span);
        object["labels"].push_back(std::move(entry));
    }
    object["help"] = diagnostic.help;
    return object;
}

}  // namespace

std::string render_json(const source::FileSet& files, const std::vector<Diagnostic>& diagnostics) {
    Json array = Json::array();
    for (const Diagnostic& diagnostic : diagnostics) array.push_back(to_json(files, diagnostic));
    // A path or a quoted piece of text may hold bytes that are no UTF-8; JSON cannot, so they become U+FFFD.
    return array.dump(2, ' ', true, Json::error_handler_t::replace) + "\n";
}

}  // namespace meld::diagnostics

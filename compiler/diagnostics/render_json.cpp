// Diagnostics as one JSON array, for editors and other programs.
#include <nlohmann/json.hpp>

#include "compiler/diagnostics/diagnostics.h"

namespace meld::diagnostics {

namespace {

using Json = nlohmann::ordered_json;

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
    object["fixes"] = Json::array();
    for (const Fix& fix : exact(files, diagnostic.fixes, [&](std::uint32_t file) { return files.file(file).on_disk(); })) {
        Json entry;
        entry["title"] = fix.title;
        entry["safe"] = fix.safe;
        entry["edits"] = Json::array();
        for (const Edit& edit : fix.edits) {
            Json change;
            put_span(change, files, edit.span);
            change["text"] = edit.text;
            entry["edits"].push_back(std::move(change));
        }
        object["fixes"].push_back(std::move(entry));
    }
    return object;
}

}  // namespace

void JsonMessages::add(const source::FileSet& files, const std::vector<Diagnostic>& diagnostics) {
    for (const Diagnostic& diagnostic : diagnostics) {
        // A path or a quoted piece of text may hold bytes that are no UTF-8; JSON cannot, so they become U+FFFD.
        const std::string object = to_json(files, diagnostic).dump(2, ' ', true, Json::error_handler_t::replace);
        objects_ += objects_.empty() ? "\n  " : ",\n  ";
        for (const char c : object) {
            objects_ += c;
            if (c == '\n') objects_ += "  ";
        }
    }
}

std::string JsonMessages::text() const { return "[" + objects_ + (objects_.empty() ? "" : "\n") + "]\n"; }

std::string render_json(const source::FileSet& files, const std::vector<Diagnostic>& diagnostics) {
    JsonMessages messages;
    messages.add(files, diagnostics);
    return messages.text();
}

}  // namespace meld::diagnostics

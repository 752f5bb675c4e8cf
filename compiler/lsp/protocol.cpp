// Only what the protocol needs is written, as LLVM's library does.
#include "compiler/lsp/protocol.h"

#include <utility>

#include "compiler/lsp/prelude_file.h"

namespace meld::lsp {

// ---- parameters

bool fromJSON(const json::Value& value, RenameParams& result, json::Path path) {
    if (!protocol::fromJSON(value, static_cast<protocol::TextDocumentPositionParams&>(result), path)) return false;
    json::ObjectMapper map(value, path);
    return map && map.map("newName", result.name);
}

bool fromJSON(const json::Value& value, FormattingParams& result, json::Path path) {
    json::ObjectMapper map(value, path);
    return map && map.map("textDocument", result.document);
}

bool fromJSON(const json::Value& value, CodeActionParams& result, json::Path path) {
    json::ObjectMapper map(value, path);
    if (!map || !map.map("textDocument", result.document) || !map.map("range", result.range)) return false;
    const json::Value* context = value.getAsObject()->get("context");
    if (context == nullptr) {
        path.field("context").report("missing value");
        return false;
    }
    json::ObjectMapper inside(*context, path.field("context"));
    return inside && inside.map("only", result.only);
}

bool CodeActionParams::wants(llvm::StringRef kind) const {
    if (!only) return true;
    for (const std::string& wanted : *only)
        if (wanted.empty() || kind == wanted || kind.starts_with(wanted + ".")) return true;
    return false;
}

bool fromJSON(const json::Value& value, InitializeParams& result, json::Path path) {
    const json::ObjectMapper map(value, path);
    if (!map) return false;
    const auto part = [](const json::Object* of, llvm::StringRef name) { return of == nullptr ? nullptr : of->getObject(name); };
    const json::Object* all = value.getAsObject();
    if (const json::Object* options = part(all, "initializationOptions"))
        if (const auto profile = options->getString("profile")) result.profile = profile->str();
    if (const json::Object* hints = part(part(part(all, "capabilities"), "workspace"), "inlayHint"))
        result.refreshes_hints = hints->getBoolean("refreshSupport").value_or(false);
    return true;
}

bool fromJSON(const json::Value& value, CommandParams& result, json::Path path) {
    json::ObjectMapper map(value, path);
    return map && map.map("command", result.command) && map.mapOptional("arguments", result.arguments);
}

// ---- places and kinds

Position from(const protocol::Position& position) { return {position.line, position.character}; }
protocol::Position to(Position position) { return {position.line, position.character}; }
protocol::Range to(Range range) { return {to(range.start), to(range.end)}; }

protocol::CompletionItemKind to(Completion::Kind kind) {
    switch (kind) {
        case Completion::Kind::Predicate:
            return protocol::CompletionItemKind::Struct;
        case Completion::Kind::Action:
            return protocol::CompletionItemKind::Event;
        case Completion::Kind::Constant:
            return protocol::CompletionItemKind::Constant;
        case Completion::Kind::Function:
            return protocol::CompletionItemKind::Function;
        case Completion::Kind::Variable:
            return protocol::CompletionItemKind::Variable;
        case Completion::Kind::Keyword:
            return protocol::CompletionItemKind::Keyword;
    }
    return protocol::CompletionItemKind::Text;
}

protocol::SymbolKind to(Outline::Kind kind) {
    switch (kind) {
        case Outline::Kind::Predicate:
            return protocol::SymbolKind::Struct;
        case Outline::Kind::Action:
            return protocol::SymbolKind::Event;
        case Outline::Kind::Constant:
            return protocol::SymbolKind::Constant;
        case Outline::Kind::Function:
            return protocol::SymbolKind::Function;
        case Outline::Kind::Rule:
            return protocol::SymbolKind::Operator;
        case Outline::Kind::File:
            return protocol::SymbolKind::File;
    }
    return protocol::SymbolKind::Null;
}

std::optional<protocol::Location> location(const Place& place) {
    const std::string path = place.path.empty() ? prelude_path() : place.path;
    if (path.empty()) return std::nullopt;
    auto uri = protocol::URIForFile::fromFile(path);
    if (!uri) {
        llvm::consumeError(uri.takeError());
        return std::nullopt;
    }
    return protocol::Location(*uri, to(place.range));
}

// ---- messages and their fixes

namespace {

// DiagnosticTag of the protocol.
constexpr int kUnnecessary = 1;

int severity(diagnostics::Severity severity) {
    switch (severity) {
        case diagnostics::Severity::Error:
            return 1;
        case diagnostics::Severity::Warning:
            return 2;
        case diagnostics::Severity::Note:
            return 3;
    }
    return 1;
}

// The library's JSON of an address borrows its text; a message that outlives the address must own it.
json::Object owned(const protocol::Location& where) {
    return json::Object{{"uri", where.uri.uri().str()}, {"range", protocol::toJSON(where.range)}};
}

}  // namespace

json::Object to_json(const Message& message) {
    json::Array related;
    for (const auto& [place, text] : message.related) {
        if (const auto where = location(place)) related.push_back(json::Object{{"location", owned(*where)}, {"message", text}});
    }
    json::Object one{{"range", protocol::toJSON(to(message.range))},
                     {"severity", severity(message.severity)},
                     {"code", message.code},
                     {"source", "meldc"},
                     {"message", message.text},
                     {"relatedInformation", std::move(related)}};
    if (message.without_use) one["tags"] = json::Array{kUnnecessary};
    return one;
}

json::Object to_json(const CostHint& hint) {
    return json::Object{{"position", protocol::toJSON(to(hint.position))},
                        {"label", hint.label},
                        {"paddingLeft", true},
                        {"tooltip", json::Object{{"kind", "markdown"}, {"value", hint.markdown}}}};
}

json::Object to_json(const Action& action) {
    json::Object changes;
    for (const auto& [path, edits] : action.edits) {
        auto uri = protocol::URIForFile::fromFile(path);
        // Programs have absolute paths, which all have an address.
        if (!uri) {
            llvm::consumeError(uri.takeError());
            continue;
        }
        json::Array list;
        for (const auto& [range, text] : edits) list.push_back(json::Object{{"range", protocol::toJSON(to(range))}, {"newText", text}});
        changes[uri->uri().str()] = std::move(list);
    }
    return json::Object{{"title", action.title},
                        {"kind", kQuickFix},
                        {"diagnostics", json::Array{to_json(action.message)}},
                        {"isPreferred", action.preferred},
                        {"edit", json::Object{{"changes", std::move(changes)}}}};
}

}  // namespace meld::lsp

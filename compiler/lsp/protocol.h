// The messages of the protocol that LLVM's library does not know, and what the answers of describe.h are in the others.
#pragma once

#include <mlir/Tools/lsp-server-support/Protocol.h>

#include <optional>
#include <string>
#include <vector>

#include "compiler/lsp/costs.h"
#include "compiler/lsp/describe.h"

namespace meld::lsp {

namespace json = llvm::json;
namespace protocol = mlir::lsp;

struct RenameParams : protocol::TextDocumentPositionParams {
    std::string name;
};
bool fromJSON(const json::Value& value, RenameParams& result, json::Path path);

struct FormattingParams {
    protocol::TextDocumentIdentifier document;
};
bool fromJSON(const json::Value& value, FormattingParams& result, json::Path path);

// The library's own refuses messages of other servers that lack what it knows; we look at none of them.
struct CodeActionParams {
    protocol::TextDocumentIdentifier document;
    protocol::Range range;
    // Kinds, which may have kinds of their own behind a full stop; none: all.
    std::optional<std::vector<std::string>> only;

    bool wants(llvm::StringRef kind) const;
};
bool fromJSON(const json::Value& value, CodeActionParams& result, json::Path path);

// Of all that an editor says of itself, only what we look at; the library's own knows neither.
struct InitializeParams {
    std::string profile;           // From the editor's options for this server: a file with the costs of rules.
    bool refreshes_hints = false;  // It asks for hints anew when it is told to.
};
bool fromJSON(const json::Value& value, InitializeParams& result, json::Path path);

struct CommandParams {
    std::string command;
    std::vector<std::string> arguments;
};
bool fromJSON(const json::Value& value, CommandParams& result, json::Path path);

// Shows the profile that its argument names beside the rules; without one, none.
inline constexpr llvm::StringLiteral kProfileCommand = "meld.profile";
inline constexpr llvm::StringLiteral kQuickFix = "quickfix";

Position from(const protocol::Position& position);
protocol::Position to(Position position);
protocol::Range to(Range range);
protocol::CompletionItemKind to(Completion::Kind kind);
protocol::SymbolKind to(Outline::Kind kind);
// Nothing if a place of the prelude has no file.
std::optional<protocol::Location> location(const Place& place);

// A diagnostic, a code action with its edits, and a hint beside a rule.
json::Object to_json(const Message& message);
json::Object to_json(const CostHint& hint);
json::Object to_json(const Action& action);

}  // namespace meld::lsp

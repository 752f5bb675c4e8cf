// The messages of the protocol that LLVM's library does not know, and what the answers of describe.h are in the others.
#pragma once

#include <mlir/Tools/lsp-server-support/Protocol.h>

#include <optional>
#include <string>
#include <vector>

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

inline constexpr llvm::StringLiteral kQuickFix = "quickfix";

Position from(const protocol::Position& position);
protocol::Position to(Position position);
protocol::Range to(Range range);
protocol::CompletionItemKind to(Completion::Kind kind);
protocol::SymbolKind to(Outline::Kind kind);
// Nothing if a place of the prelude has no file.
std::optional<protocol::Location> location(const Place& place);

// A diagnostic, and a code action with its edits.
json::Object to_json(const Message& message);
json::Object to_json(const Action& action);

}  // namespace meld::lsp

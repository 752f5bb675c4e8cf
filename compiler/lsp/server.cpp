// The protocol is LLVM's (its JSON transport and messages); the answers come from describe.h. One request is served at a time, so an answer
// is always about the current text.
#include "compiler/lsp/server.h"

#include <mlir/Tools/lsp-server-support/Logging.h>
#include <mlir/Tools/lsp-server-support/Transport.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "compiler/format/format.h"
#include "compiler/lsp/costs.h"
#include "compiler/lsp/describe.h"
#include "compiler/lsp/protocol.h"
#include "compiler/lsp/shallow_input.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/base/version.h"

namespace meld::lsp {

namespace {

template <class T>
using Reply = protocol::Callback<T>;

llvm::Error failed(const std::string& why) { return llvm::make_error<protocol::LSPError>(why, protocol::ErrorCode::RequestFailed); }

std::string normal(llvm::StringRef path) { return std::filesystem::path(path.str()).lexically_normal().string(); }

class Server {
  public:
    explicit Server(protocol::JSONTransport& transport)
        : handler_(transport),
          publish_(handler_.outgoingNotification<json::Value>("textDocument/publishDiagnostics")),
          show_message_(handler_.outgoingNotification<json::Value>("window/showMessage")),
          refresh_hints_(handler_.outgoingRequest<json::Value, std::nullptr_t>("workspace/inlayHint/refresh", &Server::forget)) {
        handler_.method("initialize", this, &Server::initialize);
        handler_.method("shutdown", this, &Server::shutdown);
        handler_.method("textDocument/hover", this, &Server::hover);
        handler_.method("textDocument/definition", this, &Server::definition);
        handler_.method("textDocument/references", this, &Server::references);
        handler_.method("textDocument/rename", this, &Server::rename);
        handler_.method("textDocument/completion", this, &Server::complete);
        handler_.method("textDocument/documentSymbol", this, &Server::symbols);
        handler_.method("textDocument/formatting", this, &Server::format);
        handler_.method("textDocument/codeAction", this, &Server::code_actions);
        handler_.method("textDocument/inlayHint", this, &Server::hints);
        handler_.method("workspace/executeCommand", this, &Server::execute);
        handler_.notification("initialized", this, &Server::ignore);
        handler_.notification("textDocument/didOpen", this, &Server::opened);
        handler_.notification("textDocument/didChange", this, &Server::changed);
        handler_.notification("textDocument/didClose", this, &Server::closed);
        handler_.notification("textDocument/didSave", this, &Server::ignore);
        handler_.notification("$/cancelRequest", this, &Server::ignore);
        handler_.notification("$/setTrace", this, &Server::ignore);
        handler_.notification("workspace/didChangeConfiguration", this, &Server::ignore);
    }

    protocol::MessageHandler& handler() { return handler_; }
    bool was_shut_down() const { return shut_down_; }

  private:
    struct Document {
        protocol::URIForFile uri;
        std::int64_t version = 0;
        std::unique_ptr<Analysis> analysis = nullptr;
    };

    // ---- life

    void initialize(const InitializeParams& params, Reply<json::Value> reply) {
        refreshes_hints_ = params.refreshes_hints;
        if (!params.profile.empty())
            if (const Result<void> shown = show_costs(params.profile); !shown)
                show_message_(json::Object{{"type", kErrorMessage}, {"message", shown.error().message()}});
        reply(json::Object{
            {"serverInfo", json::Object{{"name", "meldc"}, {"version", kVersion}}},
            {"capabilities",
             json::Object{
                 {"positionEncoding", "utf-16"},
                 {"textDocumentSync",
                  json::Object{
                      {"openClose", true}, {"change", static_cast<int>(protocol::TextDocumentSyncKind::Incremental)}, {"save", true}}},
                 {"hoverProvider", true},
                 {"definitionProvider", true},
                 {"referencesProvider", true},
                 {"renameProvider", true},
                 {"completionProvider", json::Object{{"triggerCharacters", json::Array{}}}},
                 {"documentSymbolProvider", true},
                 {"documentFormattingProvider", true},
                 {"inlayHintProvider", true},
                 {"executeCommandProvider", json::Object{{"commands", json::Array{kProfileCommand}}}},
                 {"codeActionProvider", json::Object{{"codeActionKinds", json::Array{kQuickFix}}}},
             }},
        });
    }

    void shutdown(const protocol::NoParams&, Reply<std::nullptr_t> reply) {
        shut_down_ = true;
        reply(nullptr);
    }

    void ignore(const protocol::NoParams&) {}

    // ---- texts

    void opened(const protocol::DidOpenTextDocumentParams& params) {
        const std::string path = normal(params.textDocument.uri.file());
        texts_[path] = params.textDocument.text;
        documents_[path] = {params.textDocument.uri, params.textDocument.version};
        analyse(path);
    }

    void changed(const protocol::DidChangeTextDocumentParams& params) {
        const std::string path = normal(params.textDocument.uri.file());
        const auto text = texts_.find(path);
        if (text == texts_.end()) return;
        for (const protocol::TextDocumentContentChangeEvent& change : params.contentChanges) {
            std::optional<Range> range;
            if (change.range) range = Range{from(change.range->start), from(change.range->end)};
            apply_change(text->second, range, change.text);
        }
        documents_[path].version = params.textDocument.version;
        analyse(path);
    }

    void closed(const protocol::DidCloseTextDocumentParams& params) {
        const std::string path = normal(params.textDocument.uri.file());
        const auto document = documents_.find(path);
        if (document == documents_.end()) return;
        publish(document->second, {});
        documents_.erase(document);
        texts_.erase(path);
        analyse_users(path);
    }

    void analyse(const std::string& path) {
        Document& document = documents_[path];
        document.analysis = std::make_unique<Analysis>(path, texts_);
        publish(document, document.analysis->messages());
        analyse_users(path);
    }

    // The other open programs that include the file.
    void analyse_users(const std::string& path) {
        for (auto& [other, document] : documents_) {
            if (other == path || !document.analysis || !document.analysis->uses(path)) continue;
            document.analysis = std::make_unique<Analysis>(other, texts_);
            publish(document, document.analysis->messages());
        }
    }

    void publish(const Document& document, const std::vector<Message>& messages) {
        json::Array list;
        for (const Message& message : messages) list.push_back(to_json(message));
        publish_(json::Object{{"uri", document.uri.uri().str()}, {"version", document.version}, {"diagnostics", std::move(list)}});
    }

    // ---- questions

    const Analysis* analysis(const protocol::TextDocumentIdentifier& document) const {
        const auto found = documents_.find(normal(document.uri.file()));
        return found == documents_.end() ? nullptr : found->second.analysis.get();
    }

    // The program of the document first, then the other open ones.
    std::vector<const Analysis*> programs(const Analysis& first) const {
        std::vector<const Analysis*> list{&first};
        for (const auto& [path, document] : documents_) {
            if (document.analysis && document.analysis.get() != &first) list.push_back(document.analysis.get());
        }
        return list;
    }

    static llvm::Error not_open() { return failed("this document is not open"); }

    void hover(const protocol::TextDocumentPositionParams& params, Reply<std::optional<protocol::Hover>> reply) {
        const Analysis* program = analysis(params.textDocument);
        if (program == nullptr) return reply(not_open());
        const auto text = lsp::hover(*program, from(params.position));
        if (!text) return reply(std::nullopt);
        protocol::Hover result(to(text->range));
        result.contents.value = text->markdown;
        reply(std::move(result));
    }

    void definition(const protocol::TextDocumentPositionParams& params, Reply<std::vector<protocol::Location>> reply) {
        const Analysis* program = analysis(params.textDocument);
        if (program == nullptr) return reply(not_open());
        std::vector<protocol::Location> list;
        const Occurrence* occurrence = program->at(from(params.position));
        if (occurrence != nullptr && occurrence->symbol.kind == SymbolKind::Include) {
            const auto file = program->included(occurrence->symbol.name);
            const auto where = file ? location(program->place({*file, 0, 0})) : std::nullopt;
            if (where) list.push_back(*where);
        } else if (occurrence != nullptr) {
            const auto declared = program->declaration(occurrence->symbol);
            const auto where = declared ? location(program->place(declared->second->span)) : std::nullopt;
            if (where) list.push_back(*where);
        }
        reply(std::move(list));
    }

    void references(const protocol::ReferenceParams& params, Reply<std::vector<protocol::Location>> reply) {
        const Analysis* first = analysis(params.textDocument);
        if (first == nullptr) return reply(not_open());
        std::vector<protocol::Location> list;
        const Occurrence* occurrence = first->at(from(params.position));
        for (const Analysis* program : occurrence != nullptr ? programs(*first) : std::vector<const Analysis*>{}) {
            if (program != first && (occurrence->symbol.kind == SymbolKind::Variable || !shares(*first, *program, occurrence->symbol)))
                continue;
            for (const auto& [file, one] : program->all(occurrence->symbol)) {
                if (one->role == Role::Declaration && !params.context.includeDeclaration) continue;
                const auto where = location(program->place(one->span));
                if (where && std::find(list.begin(), list.end(), *where) == list.end()) list.push_back(*where);
            }
        }
        reply(std::move(list));
    }

    // Whether the symbol is the same one in both programs: they share the file that declares it.
    static bool shares(const Analysis& first, const Analysis& other, const Symbol& symbol) {
        const auto declared = first.declaration(symbol);
        if (!declared) return false;
        return first.is_prelude(declared->first) || other.uses(first.files().file(declared->first).path());
    }

    void rename(const RenameParams& params, Reply<protocol::WorkspaceEdit> reply) {
        const Analysis* first = analysis(params.textDocument);
        if (first == nullptr) return reply(not_open());
        const auto edits = lsp::rename(programs(*first), from(params.position), params.name);
        if (!edits) return reply(failed(edits.error().problem));
        protocol::WorkspaceEdit result;
        for (const Edit& edit : *edits) {
            if (const auto where = location({edit.path, edit.range}))
                result.changes[where->uri.uri().str()].push_back({where->range, params.name});
        }
        reply(std::move(result));
    }

    void complete(const protocol::CompletionParams& params, Reply<protocol::CompletionList> reply) {
        const Analysis* program = analysis(params.textDocument);
        if (program == nullptr) return reply(not_open());
        const Completions found = lsp::complete(*program, from(params.position));
        protocol::CompletionList list;
        for (const Completion& completion : found.list) {
            protocol::CompletionItem item(completion.name, to(completion.kind));
            item.detail = completion.detail;
            if (!completion.doc.empty()) item.documentation = protocol::MarkupContent{protocol::MarkupKind::Markdown, completion.doc};
            item.textEdit = protocol::TextEdit{to(found.replaced), completion.name};
            // Variables of the rule first, words of the language last.
            item.sortText = (completion.kind == Completion::Kind::Variable  ? "0"
                             : completion.kind == Completion::Kind::Keyword ? "2"
                                                                            : "1") +
                            completion.name;
            list.items.push_back(std::move(item));
        }
        reply(std::move(list));
    }

    void symbols(const protocol::DocumentSymbolParams& params, Reply<std::vector<protocol::DocumentSymbol>> reply) {
        const Analysis* program = analysis(params.textDocument);
        if (program == nullptr) return reply(not_open());
        std::vector<protocol::DocumentSymbol> list;
        for (const Outline& entry : outline(*program)) {
            protocol::DocumentSymbol symbol(entry.name, to(entry.kind), to(entry.range), to(entry.name_range));
            symbol.detail = entry.detail;
            list.push_back(std::move(symbol));
        }
        reply(std::move(list));
    }

    void format(const FormattingParams& params, Reply<std::vector<protocol::TextEdit>> reply) {
        const Analysis* program = analysis(params.document);
        if (program == nullptr) return reply(not_open());
        source::FileSet files;
        const std::uint32_t file = files.add(program->root().path(), program->root().text());
        diagnostics::Reporter report;
        const auto text = format::format(files, file, report);
        if (!text) return reply(failed(text.error().message()));
        if (!*text) return reply(failed("a program with syntax errors is not formatted"));
        std::vector<protocol::TextEdit> edits;
        const std::string& before = program->root().text();
        if (**text != before)
            edits.push_back({to(Range{{}, position_of(program->root(), static_cast<std::uint32_t>(before.size()))}), **text});
        reply(std::move(edits));
    }

    // The fixes of the messages in a range.
    void code_actions(const CodeActionParams& params, Reply<json::Value> reply) {
        const Analysis* program = analysis(params.document);
        if (program == nullptr) return reply(not_open());
        json::Array list;
        if (params.wants(kQuickFix))
            for (const Action& action : actions(*program, {from(params.range.start), from(params.range.end)}))
                list.push_back(to_json(action));
        reply(std::move(list));
    }

    // ---- costs of rules

    void execute(const CommandParams& params, Reply<std::nullptr_t> reply) {
        if (params.command != kProfileCommand) return reply(failed("there is no command '" + visible(params.command) + "'"));
        const Result<void> shown = show_costs(params.arguments.empty() ? "" : params.arguments.front());
        if (!shown) return reply(failed(shown.error().message()));
        reply(nullptr);
        if (refreshes_hints_) refresh_hints_(nullptr, "hints-" + std::to_string(++refreshed_));
    }

    // What was shown stays if the file is no profile.
    Result<void> show_costs(const std::string& profile) {
        if (profile.empty()) {
            costs_.reset();
            return {};
        }
        Result<Costs> costs = Costs::read(profile);
        if (!costs) return tl::unexpected(costs.error());
        costs_ = std::move(*costs);
        return {};
    }

    void hints(const protocol::InlayHintsParams& params, Reply<json::Value> reply) {
        const Analysis* program = analysis(params.textDocument);
        if (program == nullptr) return reply(not_open());
        // While it is written anew it may be no profile; then the old one counts.
        if (costs_ && costs_->outdated()) (void)show_costs(std::string(costs_->path()));
        json::Array list;
        if (costs_)
            for (const CostHint& hint : costs_->hints(*program, {from(params.range.start), from(params.range.end)}))
                list.push_back(to_json(hint));
        reply(std::move(list));
    }

    // The editor's answer to a request that wants none.
    static void forget(const json::Value&, llvm::Expected<std::nullptr_t> answer) {
        if (!answer) llvm::consumeError(answer.takeError());
    }

    static constexpr int kErrorMessage = 1;  // MessageType of the protocol.

    protocol::MessageHandler handler_;
    protocol::OutgoingNotification<json::Value> publish_, show_message_;
    protocol::OutgoingRequest<json::Value> refresh_hints_;
    bool refreshes_hints_ = false;
    int refreshed_ = 0;
    std::optional<Costs> costs_;
    OpenTexts texts_;
    std::map<std::string, Document> documents_;
    bool shut_down_ = false;
};

}  // namespace

int serve(std::FILE* in, std::FILE* out) {
    // The library itself reports requests of unknown methods and broken messages to the editor; its log would only repeat them.
    llvm::raw_fd_ostream stream(fileno(out), false);
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> shallow(open_shallow(in), &std::fclose);
    protocol::JSONTransport transport(shallow.get(), stream);
    Server server(transport);
    if (llvm::Error error = transport.run(server.handler())) {
        llvm::errs() << "meldc-lsp: " << llvm::toString(std::move(error)) << "\n";
        return 1;
    }
    return server.was_shut_down() ? 0 : 1;
}

}  // namespace meld::lsp

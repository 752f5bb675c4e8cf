// Fuzz target: whatever an editor sends, each request gets one response, and what the run is asked is one line; whatever is typed, a
// command is read or refused. A line of the input is a message or, if it does not begin with a brace, a command and bytes of the protocol.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/ask/dap/adapter.h"
#include "runtime/ask/debug/command.h"
#include "runtime/base/assert.h"

namespace {

using namespace meld::dap;

// A session that answers each command in the form that it has, of a run that stands at tick 3.
class Answering : public Run {
  public:
    meld::Result<void> start(const Launch&) override {
        alive_ = true;
        return {};
    }
    meld::Result<Json> ask(const std::string& line) override {
        MELD_CHECK(line.find('\n') == std::string::npos, "a command of two lines: {}", line);
        const auto command = meld::debug::parse_command(line);
        if (!command) return tl::unexpected<meld::Error>(command.error());
        return answer(line.substr(0, line.find(' ')));
    }
    void pause() override {}
    bool alive() const override { return alive_; }
    int end() override {
        alive_ = false;
        return 0;
    }

  private:
    static Json answer(const std::string& name) {
        const auto parsed = [](const char* text) { return Json::parse(text); };
        if (name == "where" || name == "catoms")
            return parsed(R"j({"tick":3,"first_tick":0,"catoms":6,"ended":null,"digest":"d","history_bytes":9,"snapshots":1,"text":"t"})j");
        if (name == "rules")
            return parsed(R"j({"rules":[{"name":"dist@9","text":"dist(B, D + 1) :- neighbor(A, B), dist(A, D).","file":"a.meld",
                "library":false,"line":9,"last_line":11},{"name":"x@2","text":"x(A) -o y(A).","file":"lib","library":true,"line":2,
                "last_line":2}],"text":"t"})j");
        if (name == "predicates")
            return parsed(R"j({"predicates":[{"name":"dist","declaration":"type dist(node, int)","own":true
}],"text":"t"
})j");
        if (name == "help") return parsed(R"j({"help":"step   [N]  go\nfacts  [@N]  what holds\n","text":"t"})j");
        if (name == "facts")
            return parsed(R"j({"tick":3,"count":5,"catom":{"id":1,"cell":[1,2,3],"position":[1.0,2.0,3.0],"links":[{"port":0,"catom":2}],
                "actions":["a"],"coming":[{"fact":"f","tick":4}]},"facts":["dist(@1, 1).","near(@1, 1).","near(@1, 2)."],"text":"t"})j");
        if (name == "query")
            return parsed(R"j({"tick":3,"query":"q","columns":[{"name":"A","type":"node"},{"name":"D","type":"int"}],"count":3,
                "rows":[[1,2],[2,3]],"text":"t"})j");
        if (name == "why" || name == "why-not")
            return parsed(
                R"j({"why":"f","tick":3,"roots":[0],"nodes":[{"fact":"dist(@1, 1)","is":"derived","tick":3,"others":["o"],"more":2,
                "ways":[{"rule":"dist@9","text":"r","file":"a.meld","line":9,"parts":[{"is":"fact","text":"dist(@0, 0)","node":1},
                {"is":"absent","text":"q(@0)","tick":2,"note":"n"}]},{"note":"n","parts":[]}]
},{"fact":"dist(@0, 0)","is":"given","tick":3,
                "ways":[]}],"text":"t"
})j");
        if (name == "break" || name == "watch")
            return parsed(R"j({"breaks":[{"number":4,"kind":"break","what":"w","rules":[]}],"text":"t"})j");
        if (name == "run" || name == "until" || name == "reverse")
            return parsed(
                R"j({"from":3,"tick":4,"ended":null,"stops":[{"number":4,"what":"a.meld:9","ways":["A = @1, B = @2, D = [1, \"x\"]",
                "A = @2"],"more":3}],"text":"tick 4\n"})j");
        if (name == "step" || name == "back" || name == "to")
            return parsed(R"j({"from":3,"tick":4,"ended":"quiet","text":"tick 4: nothing is left to do\n"})j");
        return parsed(R"j({"text":"t"})j");
    }

    bool alive_ = false;
};

// What the adapter sends, of which only the responses are counted.
struct Sent {
    std::vector<std::int64_t> answered;
    std::int64_t seq = 0;
    void add(const std::string& framed) {
        Reader reader;
        reader.add(framed);
        const auto text = reader.next();
        MELD_CHECK(text && *text, "no message: {}", framed);
        const Json message = Json::parse(**text);
        MELD_CHECK(message.at("seq") == ++seq, "message {} instead of {}", message.at("seq").dump(), seq);
        if (message.at("type") == "response") answered.push_back(message.at("request_seq").get<std::int64_t>());
    }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::string_view input(reinterpret_cast<const char*>(data), size);
    Sent sent;
    Answering run;
    Writer client([&](const std::string& message) { sent.add(message); });
    Adapter adapter(run, client);
    Reader bytes;
    bool readable = true;
    while (!input.empty() && !adapter.over()) {
        const std::string line(input.substr(0, input.find('\n')));
        input.remove_prefix(std::min(line.size() + 1, input.size()));
        if (!line.starts_with('{')) {
            static_cast<void>(meld::debug::parse_command(line));
            bytes.add(line + "\n");
            while (readable) {
                const auto text = bytes.next();
                readable = text.has_value();
                if (!text || !*text) break;
                static_cast<void>(parse_request(**text));
            }
            continue;
        }
        const auto request = parse_request(line);
        if (!request) continue;
        const std::size_t before = sent.answered.size();
        adapter.take(*request);
        MELD_CHECK(sent.answered.size() == before + 1 && sent.answered.back() == request->seq, "{} responses to {}",
                   sent.answered.size() - before, line);
        while (adapter.has_work() && !adapter.over()) adapter.work([] { return false; });
    }
    return 0;
}

#include "io/json_text.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/data/error.hpp"
#include "io/disk_file.hpp"

namespace moraine {

namespace {

std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\')
            out += {'\\', c};
        else if (c == '\n')
            out += "\\n";
        else if (c == '\t')
            out += "\\t";
        else if (static_cast<unsigned char>(c) < 0x20)
            out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
        else
            out += c;
    }
    return out + '"';
}

struct Print {
    int indent;

    std::string operator()(std::monostate) const { return "null"; }
    std::string operator()(bool value) const { return value ? "true" : "false"; }
    std::string operator()(std::int64_t value) const { return fmt::format("{}", value); }
    std::string operator()(double value) const { return std::isfinite(value) ? fmt::format("{}", value) : "null"; }
    std::string operator()(const std::string& text) const { return quoted(text); }
    std::string operator()(const Json::List& list) const {
        std::string out = "[";
        for (const Json& item : list) out += (out.size() > 1 ? ", " : "") + item.text(indent);
        return out + "]";
    }
    std::string operator()(const Json::Named& named) const {
        if (named.empty()) return "{}";
        std::string out = "{";
        for (const auto& [name, value] : named)
            out += fmt::format("{}\n{:{}}{}: {}", out.size() > 1 ? "," : "", "", indent + 2, quoted(name),
                               value.text(indent + 2));
        return fmt::format("{}\n{:{}}}}", out, "", indent);
    }
};

}  // namespace

std::string Json::text(int indent) const {
    return std::visit(Print{indent}, value_);
}

void write_summary(const Comm& comm, const std::string& path, const Json& summary) {
    comm.agree_no_error<MachineError>(message_of([&] {
        if (comm.is_root()) replace_file(path, summary.text() + "\n");
    }));
}

}  // namespace moraine

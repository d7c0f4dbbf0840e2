#include "app/options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/program_options.hpp>
#include <sstream>

#include "comm/transport_names.hpp"
#include "core/data/error.hpp"
#include "io/input_error.hpp"
#include "scene/scene_keys.hpp"

namespace moraine {
namespace {

namespace po = boost::program_options;

struct Command {
    const char* name;
    const char* usage;
};

constexpr Command commands[] = {
    {"run", "moraine run SCENE.toml [options]     simulate; in parallel: mpirun -n P moraine run SCENE.toml\n"},
    {"check", "moraine check SCENE.toml [options]   validate; say particles, blocks, dt, steps, minutes and memory\n"},
    {"kernels",
     "moraine kernels SCENE.toml [options] compile the scene's device kernels into a folder; needs no device\n"},
    {"replay",
     "moraine replay RUN_DIR [options]     predict other ranks, partitioners and triggers from recorded loads\n"},
    {"converge", "moraine converge SCENE.toml [options]  runs on finer and finer cells: how exact a value is\n"},
    {"study", "moraine study STUDY.toml [options]    a scene with many values of its parameters (docs/scenarios.md)\n"},
    {"calibrate",
     "moraine calibrate FILE.toml [options] parameters that fit what was seen, and how well it tells them\n"},
    {"stability", "moraine stability SCENE.toml [options] factor of safety of a slope, with an error bar\n"},
    {"picture",
     "moraine picture RUN_DIR [options]    PNG of particles at chosen times and of maps, and an animation\n"},
    {"report", "moraine report RUN_DIR... [--output F]  one page about runs, side by side\n"},
    {"schema", "moraine schema                       JSON Schema of scenes, for editors (docs/guide/own-scene.md)\n"},
    {"help", "moraine help COMMAND                 its options, as moraine COMMAND --help\n"},
};

std::vector<std::string> command_names() {
    std::vector<std::string> names;
    for (const Command& command : commands) names.emplace_back(command.name);
    return names;
}

const std::vector<std::string> devices{"auto", "cpu", "cuda"};

std::vector<std::string> transports() {
    std::vector<std::string> names{"auto"};
    names.insert(names.end(), transport_names.begin(), transport_names.end());
    return names;
}

const std::vector<std::string>& partitioners() {
    return key_of(scene_rows(), "balance", "partitioner").choices;
}

[[noreturn]] void refuse_argument(const std::string& problem, const std::string& why, const std::string& suggestion) {
    throw InputError(fmt::format("{} ({}). {}", problem, why, suggestion));
}

constexpr const char* cache_meaning =
    "where compiled device kernels and laws are kept; none: nowhere (default: MORAINE_KERNEL_CACHE, else "
    "~/.cache/moraine/kernels)";
constexpr const char* code_meaning =
    "compile and run the laws that the scene has in files: code, which may do what you may";

po::options_description run_options(Options& o) {
    po::options_description options("run");
    options.add_options()("output", po::value(&o.output)->value_name("DIR"),
                          "where results go (default: runs/<scene name>)")("overwrite", po::bool_switch(&o.overwrite),
                                                                           "replace a run that is there")(
        "set", po::value(&o.sets)->value_name("KEY=VALUE"),
        "change a key of the scene; material.NAME.key and body.NAME.key address tables; again for more")(
        "allow-code", po::bool_switch(&o.allow_code), code_meaning)("device", po::value(&o.device)->value_name("NAME"),
                                                                    "auto, cpu, cuda (default: auto)")(
        "transport", po::value(&o.transport)->value_name("NAME"), (listed(transports()) + " (default: auto)").c_str())(
        "kernel-cache", po::value(&o.kernel_cache)->value_name("DIR"), cache_meaning)(
        "partitioner", po::value(&o.partitioner)->value_name("NAME"), "instead of balance.partitioner")(
        "restart", po::value(&o.restart)->value_name("FILE"), "go on from a checkpoint")(
        "allow-change", po::value(&o.allow_changes)->value_name("KEY"),
        "a key that --set may change in a restart: a strength or numerics.damping; again for more")(
        "no-particles", po::bool_switch(&o.no_particles), "write no particles.vtkhdf, only the records")(
        "trace", po::value(&o.trace)->value_name("FILE"),
        "write what each rank did when, for Perfetto or chrome://tracing (docs/trace.md)")(
        "quiet", po::bool_switch(&o.quiet), "no progress");
    return options;
}

po::options_description check_options(Options& o) {
    po::options_description options("check");
    options.add_options()("set", po::value(&o.sets)->value_name("KEY=VALUE"), "as in run")(
        "allow-code", po::bool_switch(&o.allow_code), "as in run")(
        "device", po::value(&o.device)->value_name("NAME"),
        "as in run: with a device, the host's memory is that beside it")(
        "no-particles", po::bool_switch(&o.no_particles), "as in run: the memory is that without particles.vtkhdf")(
        "ranks", po::value(&o.ranks)->value_name("P"), "predict memory and time of one of P ranks (default: 1)")(
        "time", po::bool_switch(&o.time),
        "make a second of steps and an output in the present folder, and say the time of the run from them; in "
        "parallel as run")("transport", po::value(&o.transport)->value_name("NAME"), "as in run, with --time")(
        "kernel-cache", po::value(&o.kernel_cache)->value_name("DIR"), "as in run");
    return options;
}

po::options_description kernel_options(Options& o) {
    po::options_description options("kernels");
    options.add_options()("set", po::value(&o.sets)->value_name("KEY=VALUE"), "as in run")(
        "allow-code", po::bool_switch(&o.allow_code), "as in run")(
        "kernel-cache", po::value(&o.kernel_cache)->value_name("DIR"), cache_meaning)(
        "architecture", po::value(&o.architectures)->value_name("CC"),
        "compute capability times 10, as 80 or 90; again for more (default: that of the build)");
    return options;
}

po::options_description options_of(Options& o) {
    return o.command == "run" ? run_options(o) : o.command == "check" ? check_options(o) : kernel_options(o);
}

std::vector<std::string> names_of(const po::options_description& description) {
    std::vector<std::string> names;
    for (const auto& option : description.options()) names.push_back("--" + option->long_name());
    return names;
}

/// The words after the command; the scene is the one without dashes.
void parse_arguments(const std::vector<std::string>& words, const po::options_description& visible, Options& o) {
    po::options_description all;
    std::vector<std::string> scenes;
    all.add(visible).add_options()("scene", po::value(&scenes));
    po::positional_options_description positional;
    positional.add("scene", -1);
    const std::vector<std::string> names = names_of(visible);
    try {
        namespace style = po::command_line_style;
        po::variables_map map;
        po::store(po::command_line_parser(words)
                      .options(all)
                      .positional(positional)
                      .style(style::allow_long | style::long_allow_adjacent | style::long_allow_next)
                      .run(),
                  map);
        po::notify(map);
    } catch (const po::unknown_option& e) {
        const std::string name = e.get_option_name();
        refuse_argument(name, "moraine " + o.command + " has no such option", suggest(name, names));
    } catch (const po::invalid_syntax& e) {
        refuse_argument(e.get_option_name(), "a value is missing, or not wanted", "See moraine --help?");
    } catch (const po::multiple_occurrences& e) {
        refuse_argument(e.get_option_name(), "given twice", "Remove one?");
    } catch (const po::error& e) {
        refuse_argument("the command line", e.what(), "See moraine --help?");
    }
    if (scenes.empty()) refuse_argument("no scene", "a file is needed", "Try moraine run inputs/first_scene.toml?");
    if (scenes.size() > 1)
        refuse_argument(fmt::format("two scenes, {} and {}", scenes[0], scenes[1]), "one at a time",
                        "Does each --set have its own KEY=VALUE?");
    o.scene = scenes[0];
}

void check_choice(const std::string& option, const std::string& value, const std::vector<std::string>& choices) {
    if (std::find(choices.begin(), choices.end(), value) == choices.end())
        refuse_argument(fmt::format("{} {}", option, value), "must be one of " + listed(choices),
                        suggest(value, choices));
}

void check_topic(const std::string& topic) {
    const std::vector<std::string> names = command_names();
    if (!topic.empty() && std::find(names.begin(), names.end(), topic) == names.end())
        refuse_argument("moraine help " + topic, "not a command", suggest(topic, names));
}

}  // namespace

Options parse_options(int argc, const char* const* argv) {
    const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
    Options o;
    if (words.empty() || words[0] == "help" || std::find(words.begin(), words.end(), "--help") != words.end()) {
        o.command = "help";
        for (const std::string& word : words)
            if (word != "help" && word != "--help" && o.topic.empty()) o.topic = word;
        check_topic(o.topic);
        return o;
    }
    if (words[0] == "--version") {
        o.command = "version";
        return o;
    }
    if (words[0] == "schema") {
        if (words.size() > 1) refuse_argument(words[1], "moraine schema takes no words", "Remove it?");
        o.command = "schema";
        return o;
    }
    if (words[0] == "replay") {
        o.command = "replay";
        o.replay = parse_replay({words.begin() + 1, words.end()});
        return o;
    }
    if (words[0] != "run" && words[0] != "check" && words[0] != "kernels") {
        const bool scene = words[0].ends_with(".toml");
        refuse_argument(
            words[0], "not a command",
            scene ? fmt::format("Did you mean moraine run {}?", words[0]) : suggest(words[0], command_names()));
    }
    o.command = words[0];
    parse_arguments({words.begin() + 1, words.end()}, options_of(o), o);
    check_choice("--device", o.device, devices);
    check_choice("--transport", o.transport, transports());
    if (!o.partitioner.empty()) check_choice("--partitioner", o.partitioner, partitioners());
    if (!o.allow_changes.empty() && o.restart.empty())
        refuse_argument("--allow-change without --restart", "a run from the start has any values",
                        "Add --restart CHECKPOINT, or leave it out?");
    for (const int architecture : o.architectures)
        if (architecture < 50 || architecture > 200)
            refuse_argument(fmt::format("--architecture {}", architecture), "must be a compute capability times 10",
                            "Did you mean 90?");
    if (o.ranks < 1) refuse_argument(fmt::format("--ranks {}", o.ranks), "must be at least 1", "Did you mean 1?");
    if (o.time && o.ranks > 1)
        refuse_argument(fmt::format("--time with --ranks {}", o.ranks), "what is not running cannot be timed",
                        fmt::format("Use mpirun -n {} moraine check {} --time?", o.ranks, o.scene));
    return o;
}

std::string help_text(const std::string& topic) {
    Options unused;
    std::ostringstream out;
    for (const Command& command : commands)
        if (topic.empty() || topic == command.name) out << command.usage;
    out << (topic.empty() ? "moraine --version | --help\n\n" : "\n");
    if (topic.empty() || topic == "run") out << run_options(unused) << '\n';
    if (topic.empty() || topic == "check") out << check_options(unused) << '\n';
    if (topic.empty() || topic == "kernels") out << kernel_options(unused) << '\n';
    if (topic.empty() || topic == "replay") out << replay_help();
    return out.str();
}

}  // namespace moraine

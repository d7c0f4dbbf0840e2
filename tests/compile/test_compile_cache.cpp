#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "compile/compile_cache.hpp"

using namespace moraine;
namespace fs = std::filesystem;

namespace {

/// A folder of its own, away again afterwards.
struct Folder {
    fs::path path = fs::current_path() / "compile_cache_test";
    Folder() { fs::remove_all(path); }
    ~Folder() { fs::remove_all(path); }
};

const std::string some(
    "\x7f"
    "ELF\0image\n",
    11);

}  // namespace

TEST_CASE("a program is made once and found again, also by another") {
    const Folder folder;
    const CompileCache cache(folder.path);
    int made = 0;
    const auto make = [&] {
        ++made;
        return some;
    };
    for (int i = 0; i < 2; ++i) {
        CHECK(cache.find_or_make("key", make) == some);
    }
    CHECK(made == 1);
    CHECK(CompileCache(folder.path).find("key").has_value());
    CHECK_FALSE(cache.find("another key").has_value());
    CHECK(CompileCache({}, {folder.path}).find("key").has_value());
}

TEST_CASE("a file that is damaged anywhere or cut off counts as absent") {
    const Folder folder;
    const CompileCache cache(folder.path);
    cache.find_or_make("key", [] { return some; });
    const fs::path file = folder.path / "key.kernels";
    std::ifstream in(file, std::ios::binary);
    const std::string whole((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    const auto write = [&](const std::string& bytes) { std::ofstream(file, std::ios::binary) << bytes; };
    for (std::size_t at = 0; at < whole.size(); ++at) {
        std::string damaged = whole;
        damaged[at] = static_cast<char>(damaged[at] ^ 1);
        write(damaged);
        CHECK_FALSE(cache.find("key").has_value());
        write(whole.substr(0, at));
        CHECK_FALSE(cache.find("key").has_value());
    }
    write(whole);
    CHECK(cache.find("key").has_value());
}

TEST_CASE("one of several that want the same program makes it, and the others wait") {
    const Folder folder;
    std::atomic<int> made{0};
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&] {
            CompileCache(folder.path).find_or_make("key", [&] {
                ++made;
                std::this_thread::yield();
                return some;
            });
        });
    for (std::thread& thread : threads) thread.join();
    CHECK(made == 1);
}

TEST_CASE("where nothing can be kept a program is made each time") {
    CHECK(CompileCache().find_or_make("key", [] { return some; }) == some);
    const Folder folder;
    std::ofstream(folder.path) << "a file, not a folder";
    CHECK(CompileCache(folder.path).find_or_make("key", [] { return some; }) == some);
}

TEST_CASE("a key follows from text, options, compiler and sources") {
    const std::string key = CompileCache::key("text", {"-a"}, "NVRTC 13.0", 1);
    CHECK(key.size() == 32);
    CHECK(key == CompileCache::key("text", {"-a"}, "NVRTC 13.0", 1));
    CHECK(key != CompileCache::key("text ", {"-a"}, "NVRTC 13.0", 1));
    CHECK(key != CompileCache::key("text", {"-b"}, "NVRTC 13.0", 1));
    CHECK(key != CompileCache::key("text", {"-a"}, "NVRTC 13.1", 1));
    CHECK(key != CompileCache::key("text", {"-a"}, "NVRTC 13.0", 2));
}

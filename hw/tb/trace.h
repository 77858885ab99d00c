// What every testbench needs: a trace read whole, a clock, and one way to end.
//
// A testbench prints one line, PASS with its counts or FAIL with the first difference, and exits
// with 0 or 1. A short or foreign trace is a failure.
#pragma once
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "verilated.h"

namespace tb {

[[noreturn]] inline void fail(const std::string& why) {
  std::printf("FAIL %s\n", why.c_str());
  std::exit(1);
}

class Trace {
 public:
  Trace(const std::string& path, const std::string& unit) : path_(path) {
    std::ifstream file(path);
    if (!file) fail("cannot read " + path);
    std::string line, version, of_unit;
    size_t count = 0;
    while (std::getline(file, line)) {
      if (line.rfind("//", 0) == 0) {
        std::istringstream words(line.substr(2));
        std::string key, field;
        words >> key;
        if (key == "trace") words >> version;
        if (key == "unit") words >> of_unit;
        if (key == "count") words >> count;
        if (key == "fields") {
          while (words >> field) {
            size_t at = names_.size();
            names_[field.substr(0, field.find(':'))] = at;
          }
        }
      } else if (!line.empty()) {
        const char* at = line.c_str();
        size_t fields = 0;
        for (;;) {
          char* end;
          values_.push_back(std::strtoull(at, &end, 16));
          fields++;
          if (*end != '_') break;
          at = end + 1;
        }
        if (fields != names_.size()) fail(path + ": a line of " + std::to_string(fields) + " fields");
      }
    }
    if (version != "1" || of_unit != unit) fail(path + " is not a version 1 trace of " + unit);
    if (count == 0 || values_.size() != count * names_.size())
      fail(path + " should have " + std::to_string(count) + " lines: it is short");
    lines_ = count;
  }

  size_t lines() const { return lines_; }

  size_t field(const std::string& name) const {
    auto found = names_.find(name);
    if (found == names_.end()) fail(path_ + " has no field " + name);
    return found->second;
  }

  // One line, its fields by name.
  class Line {
   public:
    Line(const Trace& trace, size_t number) : trace_(&trace), number_(number) {}
    uint64_t operator[](const char* name) const {
      return trace_->values_[number_ * trace_->names_.size() + trace_->field(name)];
    }
    size_t number() const { return number_; }
    // Ends the run where a value differs.
    void expect(const char* name, uint64_t found) const { expect(name, (*this)[name], found); }
    void expect(const char* what, uint64_t wanted, uint64_t found) const {
      if (wanted == found) return;
      char text[256];
      std::snprintf(text, sizeof text, "%s item %zu: %s is %llx, not %llx", trace_->path_.c_str(), number_, what,
                    static_cast<unsigned long long>(found), static_cast<unsigned long long>(wanted));
      fail(text);
    }

   private:
    const Trace* trace_;
    size_t number_;
  };
  Line operator[](size_t number) const { return Line(*this, number); }

 private:
  std::string path_;
  std::map<std::string, size_t> names_;
  std::vector<uint64_t> values_;
  size_t lines_ = 0;
};

// Registers start at random values: what a reset forgets shows up as a difference.
inline VerilatedContext& context(int argc, char** argv) {
  static VerilatedContext context;
  context.commandArgs(argc, argv);
  context.randReset(2);
  context.randSeed(1);
  return context;
}

// One clock. Set inputs, `settle`, look at outputs, then `tick`.
template <class Unit>
void settle(Unit& unit) {
  unit.clk_i = 0;
  unit.eval();
}

template <class Unit>
void tick(Unit& unit) {
  unit.clk_i = 1;
  unit.eval();
}

// A reset of two clocks, with an edge under it.
template <class Unit>
void reset(Unit& unit) {
  unit.rst_ni = 1;
  settle(unit);
  unit.rst_ni = 0;
  settle(unit);
  tick(unit);
  settle(unit);
  tick(unit);
  unit.rst_ni = 1;
  settle(unit);
}

inline std::string trace_path(int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') fail(std::string("usage: ") + argv[0] + " TRACE");
  return argv[1];
}

}  // namespace tb

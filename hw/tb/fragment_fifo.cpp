// fragment_fifo.sv against its trace, clock by clock.
#include "Vfragment_fifo.h"
#include "trace.h"

int main(int argc, char** argv) {
  Vfragment_fifo unit(&tb::context(argc, argv));
  tb::Trace trace(tb::trace_path(argc, argv), "fragment_fifo");
  unit.rst_ni = 1;
  unit.valid_i = unit.ready_i = 0;
  size_t read = 0;
  for (size_t i = 0; i < trace.lines(); i++) {
    auto line = trace[i];
    tb::settle(unit);
    unit.rst_ni = !line["reset"];
    unit.valid_i = line["valid_i"];
    unit.ready_i = line["ready_i"];
    unit.data_i = line["data_i"];
    tb::settle(unit);
    line.expect("ready_o", unit.ready_o);
    line.expect("valid_o", unit.valid_o);
    line.expect("held", unit.held_o);
    if (unit.valid_o) line.expect("data_o", unit.data_o);
    read += unit.valid_o && unit.ready_i && unit.rst_ni;
    tb::tick(unit);
  }
  std::printf("PASS fragment_fifo %zu clocks %zu entries\n", trace.lines(), read);
}

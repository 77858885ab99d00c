// What every Icarus testbench needs: the trace in an array of words, and one way to end. A testbench
// declares Width (bits of a line), Count (lines, from the trace's own header) and includes this.
  parameter int Count = 0;
  logic [Width-1:0] trace [0:Count-1];
  logic [1023:0]    trace_path;
  integer           at;

  // An X in what was found differs from everything.
  task automatic expect_value(input [255:0] wanted, input [255:0] found, input [8*20-1:0] what);
    if (found !== wanted) begin
      $display("FAIL line %0d: %0s is %0h, not %0h", at, what, found, wanted);
      $fatal(1);
    end
  endtask

  task automatic load;
    if (Count == 0 || !$value$plusargs("trace=%s", trace_path)) begin
      $display("FAIL no trace");
      $fatal(1);
    end
    $readmemh(trace_path, trace);
    // A short file leaves X behind.
    if (^trace[Count-1] === 1'bx) begin
      $display("FAIL the trace is short");
      $fatal(1);
    end
  endtask

// A clock and a reset for the testbenches of clocked units. Inputs change after the falling edge, outputs are
// looked at just before the rising one.
  logic clk = 0;
  logic rst_n = 1;
  always #5 clk = !clk;
  task automatic reset;
    @(negedge clk) rst_n = 0;
    @(negedge clk);
    @(negedge clk) rst_n = 1;
  endtask

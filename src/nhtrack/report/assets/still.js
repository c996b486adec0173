// A page without plots: light and dark, screen and paper, and nothing else.

watchLook(() => {});
mark('firstPlot');
mark('ready');

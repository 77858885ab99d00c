document.querySelectorAll('.choice').forEach(function (choice) {
  var compare = choice.parentNode.querySelector('.compare'), images = compare.querySelectorAll('img');
  choice.querySelectorAll('select').forEach(function (select, side) {
    function show() {
      var chosen = document.getElementById(select.value);
      images[side].src = chosen.src;
      images[side].alt = chosen.alt;
    }
    select.addEventListener('change', show);
    show();
  });
  var slide = choice.parentNode.querySelector('.slide');
  slide.addEventListener('input', function () { compare.style.setProperty('--at', slide.value + '%'); });
});
window.addEventListener('load', function () {
  var figures = Array.from(document.querySelectorAll('figure'));
  var there = figures.filter(function (figure) {
    var images = Array.from(figure.querySelectorAll('img'));
    var drawn = images.length || figure.querySelector('svg path, svg polyline, svg circle, td, .bar i');
    return drawn && images.every(function (image) { return image.complete && image.naturalWidth > 0; });
  });
  document.documentElement.dataset.figures = there.length + ' of ' + figures.length;
  document.documentElement.dataset.overflow = document.documentElement.scrollWidth > window.innerWidth;
});

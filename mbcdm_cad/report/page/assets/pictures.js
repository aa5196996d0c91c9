// A picture for each step of assembly, drawn from the same model when the steps become visible; new parts are blue.
(function (page) {
  "use strict";
  const WIDTH = 480, HEIGHT = 320;

  page.stepPictures = function (viewer, rows) {
    const joined = rows.map((row) => JSON.parse(row.dataset.items));
    const draw = (index) => {
      if (index === rows.length) {
        viewer.small?.dispose();
        document.documentElement.dataset.pictured = "yes";
        return;
      }
      if (joined[index].length) {
        const image = document.createElement("img");
        image.alt = `Step ${index + 1}: ${joined[index].join(", ").replaceAll("_", " ")}`;
        image.src = viewer.picture(joined.slice(0, index + 1).flat(), joined[index], WIDTH, HEIGHT);
        rows[index].classList.add("pictured");
        rows[index].prepend(image);
      }
      setTimeout(() => draw(index + 1), 0); // the page answers in between
    };
    const sight = new IntersectionObserver((found) => {
      if (!found.some((entry) => entry.isIntersecting)) return;
      sight.disconnect();
      draw(0);
    }, { rootMargin: "300px" });
    sight.observe(document.getElementById("assembly"));
  };
})(window.drivePage);


// The viewer as a widget of notebooks (anywidget): state goes both ways, the camera comes back.
async function render({ model, el }) {
    const bytes = (value) => new Uint8Array(value.buffer, value.byteOffset, value.byteLength);
    const box = el.appendChild(document.createElement("div"));
    const fit = () => { box.style.height = `${model.get("height")}px`; };
    fit();
    const options = { ...model.get("options"), looks: { ...model.get("looks") } };
    let viewer;
    try {
        viewer = new Viewer(box, await unpacked(bytes(model.get("scene"))), options);
    } catch (error) {
        box.textContent = error.message;
        return;
    }
    const names = ["look", "show", "compare", "wipe", "strength", "radius"];
    const told = {}; // what the other side knows
    const take = () => {
        const state = Object.fromEntries(names.map((name) => [name, model.get(name)]));
        Object.assign(told, state);
        viewer.show({ ...state, looks: model.get("looks") });
    };
    const takePose = () => {
        const { pose } = model.get("camera_state");
        if (pose && `${pose}` !== `${viewer.eye.pose}`) viewer.show({ pose });
    };
    viewer.onchange = () => {
        for (const name of names) {
            if (viewer.state[name] !== told[name]) model.set(name, (told[name] = viewer.state[name]));
        }
        const { pose, lens, moved } = viewer.eye;
        model.set("camera_state", { pose: [...pose], ...lens, range: viewer.eye.range(), name: moved ? "" : viewer.eye.camera.name });
        model.save_changes();
    };
    for (const name of [...names, "looks"]) model.on(`change:${name}`, take);
    model.on("change:camera_state", takePose);
    model.on("change:height", fit);
    take();
    return () => viewer.dispose();
}

export default { render };
